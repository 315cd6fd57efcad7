      module tf_model
      use, intrinsic :: iso_c_binding, only: c_int, c_double
      implicit none
      integer, parameter :: tf_states = @STATES@
      integer, parameter :: tf_system = @SYSTEM@
      interface
        integer(c_int) function tf_mu(loads, state, system, clamp, mu)
     &bind(c,name='@P@_mu')
          import :: c_int, c_double
          real(c_double), intent(in) :: loads(*), state(*), system(*)
          integer(c_int), value :: clamp
          real(c_double), intent(out) :: mu
        end function tf_mu
        integer(c_int) function tf_step(loads, system, dt, state)
     &bind(c,name='@P@_step')
          import :: c_int, c_double
          real(c_double), intent(in) :: loads(*), system(*)
          real(c_double), value :: dt
          real(c_double), intent(inout) :: state(*)
        end function tf_step
        subroutine tf_start(loads, state, system)
     &bind(c,name='@P@_start')
          import :: c_double
          real(c_double) :: loads(*), state(*), system(*)
        end subroutine tf_start
        real(c_double) function tf_distance(loads, load)
     &bind(c,name='@P@_domain_distance')
          import :: c_int, c_double
          real(c_double), intent(in) :: loads(*)
          integer(c_int), intent(out) :: load
        end function tf_distance
      end interface
      end module tf_model
