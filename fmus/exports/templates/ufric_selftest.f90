! Calls UFRIC as Marc does - several contact points, iterations, increments cut back, contact lost and found again -
! and compares the coefficients with those in selftest.txt, which ONNX Runtime computed from model.onnx:
!     gfortran ufric.f selftest.f90 @P@.o -lm -o selftest && ./selftest
! prints "ok" and the largest deviation, or what went wrong, and then ends with 1.
program selftest
    implicit none
    integer :: node, inc, calls, unit, status, mibody(4)
    double precision :: time, x(3), f(3), v(3), temp(2), yiel, fric, expected, worst
    character(len=200) :: file
    logical :: wrong
    file = 'selftest.txt'
    if (command_argument_count() > 0) call get_command_argument(1, file)
    open (newunit=unit, file=file, status='old', action='read')
    x = 0d0
    yiel = 500d0
    calls = 0
    worst = 0d0
    wrong = .false.
    do
        v = 0d0
        f = 0d0
        temp = 0d0
        read (unit, *, iostat=status) node, inc, time, x(1), x(2), v(1), v(2), temp(1), f(1), expected
        if (status /= 0) exit
        mibody = [node, 0, 0, node]
        fric = -1d0
        call ufric(mibody, x, f, v, temp, yiel, fric, time, inc, 1)
        calls = calls + 1
        if (expected < 0d0) cycle ! an iteration before the last one, or of an increment that is cut back
        worst = max(worst, abs(fric - expected))
        if (.not. abs(fric - expected) <= 1d-11 * abs(expected) + 1d-13) then
            write (*, '(a,i0,a,i0,2(a,es24.16))') 'point ', node, ', increment ', inc, ': ', fric, ', expected ', expected
            wrong = .true.
        end if
    end do
    if (wrong .or. calls == 0) stop 1
    write (*, '(a,i0,a,es8.1)') 'ok: ', calls, ' calls, largest deviation', worst
end program selftest
