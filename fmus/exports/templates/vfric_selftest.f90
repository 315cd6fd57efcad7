! Calls VFRIC and VFRICTION as Abaqus/Explicit does, increment by increment with the points in contact, and compares
! the friction forces with those in selftest.txt, from coefficients that ONNX Runtime computed from model.onnx:
!     gfortran -I selftest vfric.f selftest/selftest.f90 @P@.o -lm -o run && ./run selftest/selftest.txt
! prints "ok" and the largest deviation of mu, or what went wrong, and then ends with 1.
program selftest
    implicit none
    integer, parameter :: most = 8, depvar = @DEPVAR@, n_props = 2 + @SYSTEM@
    integer :: unit, status, inc, n, k, which, calls, points(most)
    double precision :: dt, slip(3, most), normal(most), area(most), t_sec(most), t_main(most), expected(most), worst
    double precision :: state(depvar, most, 2), props(n_props), force(2, most), stick(most)
    character(len=200) :: file
    logical :: wrong
    file = 'selftest.txt'
    if (command_argument_count() > 0) call get_command_argument(1, file)
    open (newunit=unit, file=file, status='old', action='read')
    read (unit, *) props
    state = 0d0
    calls = 0
    worst = 0d0
    wrong = .false.
    do
        read (unit, *, iostat=status) inc, dt, n
        if (status /= 0) exit
        do k = 1, n
            read (unit, *) points(k), slip(:, k), normal(k), area(k), t_sec(k), t_main(k), expected(k)
        end do
        stick = 1d30
        if (inc == 2) stick = 0.5d0 * expected * normal ! sticking limits the force
        do which = 1, 2
            force = 7d0
            if (which == 1) call contact_pair()
            if (which == 2) call general_contact()
            do k = 1, n
                calls = calls + 1
                call compare(force(1, k), -min(expected(k) * normal(k), stick(k)), normal(k))
                if (force(2, k) /= 0d0) wrong = .true.
            end do
        end do
    end do
    if (wrong .or. calls == 0) stop 1
    write (*, '(a,i0,a,es8.1)') 'ok: ', calls, ' forces, largest deviation of mu', worst
contains
    subroutine compare(value, wanted, scale)
        double precision, intent(in) :: value, wanted, scale
        double precision :: difference
        difference = abs(value - wanted) / max(scale, 1d-30)
        worst = max(worst, difference)
        if (difference <= @TOLERANCE@) return
        write (*, '(a,i0,a,i0,2(a,es24.16))') 'call ', which, ', increment ', inc, ': ', value, ', expected ', wanted
        wrong = .true.
    end subroutine compare

    subroutine contact_pair()
        integer :: sec(most), main_nodes(2, most), uid(most)
        double precision :: areas(most), shape(2, most), t_nodes(2 * most), x(3, most), pre(most, 1), work, ones(3, most)
        character(len=80) :: name
        areas = 0d0
        do k = 1, n
            sec(k) = points(k)
            areas(points(k)) = area(k)
            main_nodes(:, k) = [2 * k - 1, 2 * k]
            shape(:, k) = [0.25d0, 0.75d0]
            t_nodes(2 * k - 1) = t_main(k) - 3d0 ! between two nodes: 0.25 (-3) + 0.75 (+1) = 0
            t_nodes(2 * k) = t_main(k) + 1d0
        end do
        name = ' '
        uid = 0
        x = 0d0
        ones = 0d0
        pre = 0d0
        work = 0d0
        call vfric(force, state(:, :, 1), 1, inc, n, 2, most, 2 * most, 2, 3, depvar, n_props, 1, 1, 2 * most, &
                   uid, main_nodes, sec, main_nodes, 0d0, 0d0, dt, name, name, name, 0, slip, stick, ones, normal, work, &
                   shape, x, x, ones, ones, props, areas, t_sec, pre, t_nodes, pre)
    end subroutine contact_pair

    subroutine general_contact()
        integer :: uid(4, most), flags(3)
        double precision :: held(depvar, 1, most), x(3, 4, most), r_data(4), ones(3, most), shape(4, most), field(1, most)
        character(len=80) :: name
        do k = 1, n
            held(:, 1, k) = state(:, points(k), 2)
        end do
        name = ' '
        flags = [1, inc, 0]
        r_data = [0d0, 0d0, dt, 0d0]
        uid = 0
        x = 0d0
        ones = 0d0
        shape = 0.25d0
        field = 0d0
        call vfriction(force, held, n, n, 1, 1, 1, 4, 2, 3, depvar, n_props, 1, 1, flags, r_data, name, name, name, &
                       uid, uid, props, slip, stick, ones, normal, area, ones, ones, shape, shape, x, x, x, x, &
                       t_sec, t_main, field, field)
        do k = 1, n
            state(:, points(k), 2) = held(:, 1, k)
        end do
    end subroutine general_contact
end program selftest

subroutine xplb_exit
    stop 2
end subroutine xplb_exit
