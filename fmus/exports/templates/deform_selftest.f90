! Calls USRBCC and USRUPD as DEFORM-2D does - the edges in every iteration, the elements and the nodes at the end of each
! step, then the node variables are handed on - and compares with the coefficients in selftest.txt, which come from ONNX Runtime:
!     gfortran -I. deform.f usr_bcc.f usr_upd.f selftest.f90 @P@.o -lm -o selftest && ./selftest
! prints "ok" and the largest deviation, or what went wrong, and then ends with 1.
program selftest
    implicit none
    integer, parameter :: most = 10000, room = 1500, held = @NODE_VARIABLES@ + 3
    double precision :: usrnod(held, most), next(held, most)
    integer*4 :: kobj, istatus, kstep, ksstep, nodee(4), kele, kelel, kgroup, knode, intnal
    double precision :: dtmaxc, rze(2, 4), urze(2, 4), stse(6), epse(6), efepse, efstse, tepse, rdtye, tempe(4), dtmpe(4)
    double precision :: damage, usre1(room), usre2(room), usrne(room, 4), rzn(2), urzn(2), drzn(2), tempn, dtmpn
    double precision :: usrn1(room), usrn2(room), arean, tmpneb, sldvel_n, presr(2), tmpenv, tmpslf, sldvel, press
    common /usrctl/ kobj, istatus, kstep, ksstep
    common /sstu/ dtmaxc
    common /elmcom/ rze, urze, stse, epse, efepse, efstse, tepse, rdtye, tempe, dtmpe, damage, usre1, usre2, usrne, nodee, &
        kele, kelel, kgroup
    common /nodcom/ rzn, urzn, drzn, tempn, dtmpn, usrn1, usrn2, knode
    common /nodcom2/ arean, tmpneb, sldvel_n, presr, intnal
    common /ufhcom/ tmpenv, tmpslf, sldvel, press
    integer :: unit, status, edges, nodes, calls, k, n1, n2, nbcd(2, 2)
    double precision :: worst, expected, value, rz(2, 2), drz(2, 2), temo(2), temc(2)
    character(len=200) :: file
    logical :: wrong
    file = 'selftest.txt'
    if (command_argument_count() > 0) call get_command_argument(1, file)
    open (newunit=unit, file=file, status='old', action='read')
    usrnod = 0d0
    calls = 0
    worst = 0d0
    wrong = .false.
    nbcd = 0
    rz = 0d0
    drz = 0d0
    usre1 = 3d0
    usrn1 = 4d0
    usre2 = 0d0
    kstep = 0
    do
        read (unit, *, iostat=status) dtmaxc, edges, nodes
        if (status /= 0) exit
        kstep = kstep + 1
        do k = 1, edges
            read (unit, *) n1, n2, temc, tmpenv, sldvel, press, expected
            temo = temc
            value = -7d0
            call usrbcc(value, n1, n2, 1, nbcd, 2, rz, drz, usrnod, held, tmpenv, temo, temc, 0d0, 1, 2, 4, 2)
            if (value /= -7d0) wrong = .true. ! a heat flux was asked for
            call usrbcc(value, n1, n2, 1, nbcd, 2, rz, drz, usrnod, held, tmpenv, temo, temc, 0d0, 1, 1, 2, 2)
            if (expected < 0d0) cycle ! an iteration of which nothing is known
            call compare(value)
        end do
        do istatus = 0, 1
            kele = 1
            knode = 0
            call usrupd(1)
            if (istatus == 1 .and. any(usre2 /= 3d0)) wrong = .true.
            kele = 0
            next = usrnod
            do k = 1, nodes
                if (istatus == 0) then
                    knode = k
                    usrn1(1:held) = usrnod(:, k)
                    call usrupd(1)
                    cycle
                end if
                read (unit, *) knode, tempn, tmpneb, sldvel_n, presr, arean, intnal, expected
                usrn1(1:held) = usrnod(:, knode)
                usrn2 = -5d0
                call usrupd(1)
                next(:, knode) = usrn2(1:held)
                if (usrn2(room) /= usrn1(room)) wrong = .true. ! what belongs to others is handed on
                if (expected >= 0d0) call compare(usrn2(4))
            end do
        end do
        usrnod = next
    end do
    if (wrong .or. calls == 0) stop 1
    write (*, '(a,i0,a,es8.1)') 'ok: ', calls, ' coefficients, largest deviation', worst
contains
    subroutine compare(found)
        double precision, intent(in) :: found
        calls = calls + 1
        worst = max(worst, abs(found - expected))
        if (abs(found - expected) <= 1d-11 * abs(expected) + 1d-13) return
        write (*, '(a,i0,2(a,es24.16))') 'step ', kstep, ': ', found, ', expected ', expected
        wrong = .true.
    end subroutine compare
end program selftest
