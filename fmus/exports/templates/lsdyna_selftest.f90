! Calls USRFRC as LS-DYNA does - once a cycle and interface with the active nodes - and compares the coefficients with those in
! selftest.txt, which come from ONNX Runtime:
!     gfortran -fdefault-real-8 -fdefault-double-8 lsdyna.f selftest.f90 @P@.o -lm -o selftest && ./selftest
! prints "ok" and the largest deviation, or what went wrong, and then ends with 1. Without both flags it is the single
! precision version, which agrees to about 1e-6.
program selftest
    implicit none
    integer, parameter :: most = 10000, inputs = 1 + @SYSTEM@
    integer :: unit, status, n, k, calls, ncycle, insv(most), iisv5(most), ints(most)
    real :: areas(most), aream(most), fni(most), d(most, 3), normals(most, 3), fric(most, 4), ua(inputs), reals(most), time, dt
    double precision :: expected(most), worst, found
    character(len=200) :: file
    character(len=6) :: side
    logical :: wrong
    file = 'selftest.txt'
    if (command_argument_count() > 0) call get_command_argument(1, file)
    open (newunit=unit, file=file, status='old', action='read')
    calls = 0
    worst = 0d0
    wrong = .false.
    ints = 0
    reals = 0.
    time = 0.
    ncycle = 0
    read (unit, *) ua(2:)
    do
        read (unit, *, iostat=status) dt, n, ua(1)
        if (status /= 0) exit
        ncycle = ncycle + 1
        time = time + dt
        do k = 1, n
            iisv5(k) = n + 1 - k ! pointers into the arrays, here from the back
            read (unit, *) insv(k), areas(k), aream(k), fni(k), d(k, :), normals(k, :), expected(k)
        end do
        side = 'slave'
        fric = 0.3
        call usrfrc(7, time, ncycle, dt, insv, areas, reals, reals, reals, ints, ints, ints, ints, ints, aream, reals, reals, &
                    reals, reals, reals, fni, d(:, 1), d(:, 2), d(:, 3), 1. / dt, inputs, ua, side, iisv5, n, normals(:, 1), &
                    normals(:, 2), normals(:, 3), fric(:, 1), fric(:, 2), fric(:, 3), fric(:, 4), 0., reals, ints)
        do k = 1, n
            calls = calls + 1
            found = fric(k, 1)
            if (expected(k) < 0d0) then ! no force, or a number that is none: the coefficients of the input stay
                if (any(fric(k, :) /= 0.3)) wrong = .true.
                cycle
            end if
            worst = max(worst, abs(found - expected(k)))
            if (fric(k, 2) /= fric(k, 1) .or. fric(k, 3) /= 0. .or. fric(k, 4) /= 0.) wrong = .true.
            if (abs(found - expected(k)) <= max(1d-11, 1d2 * epsilon(time)) * abs(expected(k)) + 1d-13) cycle
            write (*, '(a,i0,a,i0,2(a,es24.16))') 'node ', insv(k), ', cycle ', ncycle, ': ', found, ', expected ', expected(k)
            wrong = .true.
        end do
    end do
    if (wrong .or. calls == 0) stop 1
    write (*, '(a,i0,a,es8.1)') 'ok: ', calls, ' coefficients, largest deviation', worst
end program selftest
