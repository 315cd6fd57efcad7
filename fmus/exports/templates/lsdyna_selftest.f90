! Calls USRFRC as LS-DYNA does - once a cycle with the active nodes of an interface - and compares the friction forces with those
! of the coefficients in selftest.txt, which come from ONNX Runtime:
!     gfortran -fdefault-real-8 -fdefault-double-8 lsdyna.f selftest.f90 @P@.o -lm -o selftest && ./selftest
! prints "ok" and the largest deviation of mu, or what went wrong, and then ends with 1. Without both flags it is the single
! precision version, which agrees to about 1e-6.
program selftest
    implicit none
    integer, parameter :: most = 10000, inputs = 1 + @SYSTEM@, nhv = @HISTORY@ + 2
    integer :: unit, status, n, i, calls, ncycle, node(most), insv(most), iisv5(most), ix(most, 4), ints(most)
    integer :: ilbsv(most), iseg(most)
    real :: areas(most), fni(most), d(most, 3), normals(most, 3), fdat(5, most), f(most, 3), stfk(most), frc(2, most)
    real :: ss(most), tt(most), temp(5 * most), ufhist(nhv, most), ufeps(1, most), reals(most), pld(2, 1)
    real :: ua(inputs), time, dt, stiff
    double precision :: expected(most), t_node, t_segment, worst, found, wanted, length, off, along(3), exact
    character(len=200) :: file
    logical :: wrong
    file = 'selftest.txt'
    if (command_argument_count() > 0) call get_command_argument(1, file)
    open (newunit=unit, file=file, status='old', action='read')
    calls = 0
    worst = 0d0
    wrong = .false.
    exact = max(1d-11, 1d2 * epsilon(time))
    ufhist = 0.
    ufhist(nhv, :) = 3.
    ufeps = 0.
    reals = 0.
    pld = 0.
    ints = 0
    frc = 1.
    ss = 0.5
    tt = -0.5
    time = 0.
    ncycle = 0
    read (unit, *) ua(2:)
    do
        read (unit, *, iostat=status) dt, n, ua(1), stiff ! the last: penalty stiffness of the contact
        if (status /= 0) exit
        ncycle = ncycle + 1
        time = time + dt
        do i = 1, n
            iisv5(i) = n + 1 - i ! pointers into the arrays, here from the back
            read (unit, *) node(i), areas(i), fni(i), d(i, :), normals(i, :), t_node, t_segment, expected(i)
            ilbsv(i) = node(i)
            insv(i) = 5 * i - 4
            ix(i, :) = insv(i) + [1, 2, 3, 4]
            temp(insv(i)) = t_node
            ! Of the segment's corners 0.1875, 0.5625, 0.1875 and 0.0625 count at ss = 0.5, tt = -0.5.
            temp(ix(i, :)) = t_segment + [3, -1, 0, 0]
        end do
        stfk = stiff
        fdat = 0.
        f = 2.
        call usrfrc(7, time, ncycle, dt, insv, areas, reals, reals, reals, ints + 1, ix(:, 1), ix(:, 2), ix(:, 3), ix(:, 4), &
                    reals, reals, reals, reals, reals, reals, fni, d(:, 1), d(:, 2), d(:, 3), 1. / dt, inputs, ua, 'slave ', &
                    iisv5, n, normals(:, 1), normals(:, 2), normals(:, 3), 0.25, 0.25, 0., 0., 0., fdat, iseg, f(:, 1), &
                    f(:, 2), f(:, 3), ss, tt, ilbsv, stfk, frc, 1, ints, pld, ints, ints, temp, reals, reals, &
                    reshape(ints, [1, most]), nhv, ufhist, 1, ufeps, 1.)
        do i = 1, n
            calls = calls + 1
            along = d(i, :) - sum(dble(d(i, :)) * normals(i, :)) * normals(i, :)
            length = sqrt(sum(along**2))
            wanted = min(expected(i) * max(-dble(fni(i)), 0d0), stiff * length)
            found = sqrt(sum(dble(fdat(3:5, i))**2))
            off = abs(found - wanted) / max(-dble(fni(i)), tiny(1d0))
            if (fni(i) >= 0.) off = found
            worst = max(worst, off)
            if (any(abs(f(i, :) - 2. - fdat(3:5, i)) > exact * max(1d0, found) * 10)) wrong = .true.
            if (length > 0d0 .and. found > 0d0) then
                if (any(abs(fdat(3:5, i) / found - along / length) > 1d3 * exact)) wrong = .true.
            end if
            if (iseg(i) /= 1 .or. fdat(1, i) /= ss(i) .or. fdat(2, i) /= tt(i)) wrong = .true.
            if (ufhist(nhv, node(i)) /= 3.) wrong = .true.
            if (off <= exact * expected(i) + 1d-13) cycle
            write (*, '(a,i0,a,i0,2(a,es24.16))') 'node ', node(i), ', cycle ', ncycle, ': ', found, ', expected ', wanted
            wrong = .true.
        end do
    end do
    if (wrong .or. calls == 0) stop 1
    write (*, '(a,i0,a,es8.1)') 'ok: ', calls, ' coefficients, largest deviation', worst
end program selftest
