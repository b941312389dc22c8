!> Periodic motions of structures: the determinant of [P], and motions with rest.
module studies_structures
   use checks, only: check, check_close
   use vi_kinds, only: wp
   use vi_motion, only: yes
   use vi_status, only: stat
   use vi_structure, only: load_type, new_load, new_structure, structure_type
   use vi_structure_period, only: eliminated, exact, full, periodic_structure, structure_motion_type
   use vi_structure_return, only: settle, settled_type
   implicit none (type, external)
   private

   public :: test_structures

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   subroutine test_structures()
      call test_pair()
      call test_coupled_damping()
      call test_rest()
   end subroutine test_structures

   !> The third column of Table 1 of the 1983 paper by its two masses: three ways, one motion.
   subroutine test_pair()
      type(structure_type) :: structure
      type(load_type) :: load
      type(structure_motion_type) :: motion, found
      ! 12 digits by an independent program
      real(wp), parameter :: phases(2) = [0.517272128279_wp, 1.899298624085_wp]*pi
      integer :: wanted, status

      call oscillator([0.75_wp, 0.75_wp], 0.042_wp, 0.005_wp, 37.0_wp, structure)
      load = sine_load(0.94_wp)
      call periodic_structure(structure, load, [1, 2], phases, 1, exact, motion, status)
      call check(status == stat%ok, 'an exact motion of two masses')
      associate (verdicts => motion%verdicts)
         call check(all([verdicts%consistent, verdicts%admissible, verdicts%stable] == yes), &
            'the motion of Table 1 is consistent, admissible and stable')
         call check_close(verdicts%determinant, verdicts%law, 1.0e-12_wp, 'det[P]')
         call check_close(verdicts%law, exp(-4*pi*0.005_wp/0.94_wp)*0.75_wp**4, 1.0e-13_wp, &
            'the law of det[P]')
      end associate
      do wanted = eliminated, full
         call oscillator([0.75_wp, 0.75_wp], 0.042_wp, 0.005_wp, 37.0_wp, structure)
         call periodic_structure(structure, load, [1, 2], motion%phases, 1, wanted, found, status)
         call check(status == stat%ok, 'linear equations at the phases of a motion')
         call check(maxval(abs(found%states - motion%states)) < 1.0e-10_wp, &
            'the linear equations give the exact motion')
      end do
   end subroutine test_pair

   !> Modes that damping couples: a spring and a dashpot between host and particle.
   subroutine test_coupled_damping()
      type(structure_type) :: structure
      type(load_type) :: load
      type(settled_type) :: found
      real(wp) :: matrices(2, 2, 3), nothing(2)
      integer :: status

      matrices(:, :, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.2_wp], [2, 2])
      matrices(:, :, 2) = reshape([0.15_wp, -0.1_wp, -0.1_wp, 0.1_wp], [2, 2])
      matrices(:, :, 3) = reshape([1.1_wp, -0.1_wp, -0.1_wp, 0.1_wp], [2, 2])
      structure = new_structure(matrices, reshape([-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp], [2, 2]), &
         reshape([0.5_wp, 0.0_wp, 0.8_wp, 0.6_wp, 0.0_wp, 0.7_wp], [3, 2]))
      load = sine_load(0.9_wp)
      nothing = 0
      call settle(structure, load, 0.0_wp, nothing, nothing, 300, 8, 0, found, status)
      call check(status == stat%ok, 'a motion with damping that couples the modes')
      if (status /= stat%ok) return
      associate (verdicts => found%motion%verdicts)
         call check(verdicts%consistent == yes .and. verdicts%admissible == yes, &
            'it is consistent and admissible')
         if (size(found%resting) == 0) call check_close(verdicts%determinant, verdicts%law, &
            1.0e-10_wp, 'its det[P]')
      end associate
   end subroutine test_coupled_damping

   !> Accumulation and rest on one wall: two multipliers vanish.
   subroutine test_rest()
      type(structure_type) :: structure
      type(settled_type) :: found
      real(wp) :: nothing(2)
      integer :: status

      call oscillator([0.75_wp, 0.61_wp], 0.028_wp, 0.0114_wp, 6.0_wp, structure)
      nothing = 0
      call settle(structure, sine_load(0.9_wp), 0.0_wp, nothing, nothing, 200, 8, 0, found, status)
      call check(status == stat%ok, 'a motion with rest')
      if (status /= stat%ok) return
      call check(all(found%resting == 2) .and. size(found%resting) == 1, &
         'it rests on its left wall')
      call check(all(found%rests(2, :) > found%rests(1, :)), 'and is released later')
      associate (moduli => abs(found%motion%verdicts%multipliers))
         call check(all(moduli(3:) < 1.0e-10_wp), 'two multipliers vanish')
         call check(moduli(1) < 1 .and. found%motion%verdicts%stable == yes, 'it is stable')
      end associate
   end subroutine test_rest

   !> The oscillator of 1983 as a structure of two masses.
   subroutine oscillator(restitution, mu, xi, clearance, structure)
      !> R of the right and the left wall; mass ratio, damping ratio, clearance.
      real(wp), intent(in) :: restitution(2), mu, xi, clearance
      !> The structure.
      type(structure_type), intent(out) :: structure
      real(wp) :: matrices(2, 2, 3), gaps(3, 2)

      matrices = 0
      matrices(1, 1, :) = [1.0_wp, 2*xi, 1.0_wp]
      matrices(2, 2, 1) = mu
      gaps = 0
      gaps(1, :) = 0.5_wp*clearance
      gaps(3, :) = restitution
      structure = new_structure(matrices, reshape([-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp], [2, 2]), gaps)
   end subroutine oscillator

   !> A unit sine on the first coordinate.
   pure function sine_load(frequency) result(load)
      !> Omega.
      real(wp), intent(in) :: frequency
      type(load_type) :: load
      real(wp) :: harmonics(2, 2, 1), constant(2)

      harmonics = 0
      harmonics(1, 2, 1) = 1
      constant = 0
      load = new_load(frequency, harmonics, constant)
   end function sine_load

end module studies_structures
