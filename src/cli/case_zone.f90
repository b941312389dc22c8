!> The case of a &zone group, checked.
module vi_case_zone
   use vi_case_type, only: case_type
   use vi_family, only: can_be_symmetric
   use vi_keys, only: complain
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_orbit, only: most_impacts
   use vi_pattern, only: starred_pattern
   use vi_raw, only: raw_type
   use vi_sheet, only: zone_request_type
   use vi_text, only: lower, shown
   implicit none (type, external)
   private

   public :: check_window, take_zone

contains

   !> Checks the variables of &zone and puts them into a case.
   subroutine take_zone(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: n

      associate (zone => raw%zone)
         case%symmetric = trim(lower(zone%symmetric))
         case%pattern = starred_pattern(trim(zone%sides), zone%cycles)
         case%zone = zone_request_type(case%osc, case%pattern, .false., [zone%r_min, zone%r_max], &
            [zone%clearance_min, zone%clearance_max], zone%lines, zone%guesses, zone%max_points)
         n = size(case%pattern%sides)
         if (n < 2 .or. n > most_impacts .or. any(case%pattern%sides == 0) .or. &
            all(case%pattern%sides > 0) .or. all(case%pattern%sides < 0)) then
            call complain(group, 'sides', line, message)
         else if (zone%cycles < 1 .or. zone%cycles > 10000) then
            call complain(group, 'cycles', line, message)
         else if (all(case%symmetric /= [character(4) :: 'yes', 'no', 'both'])) then
            call complain(group, 'symmetric', line, message)
         else if (case%symmetric == 'yes' .and. &
            .not. can_be_symmetric(case%pattern, case%osc%restitution)) then
            call complain(group, 'symmetric', line, message, '''yes'' needs equal restitution, an &
               &odd number of cycles and sides whose second half mirrors the first')
         else
            call check_window(group, case, line, message)
         end if
      end associate
   end subroutine take_zone

   !> Checks the window and the limits of the search in `case%zone`.
   subroutine check_window(group, case, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message

      associate (zone => case%zone, r => case%zone%r, d => case%zone%clearance)
         if (.not. (r(1) >= 1.0e-6_wp .and. r(1) <= 1.0e6_wp)) then
            call complain(group, 'r_min', line, message)
         else if (.not. (r(2) > r(1) .and. r(2) <= 1.0e6_wp)) then
            call complain(group, 'r_max', line, message, 'r_min is '//shown(r(1), 'g0.10'))
         else if (case%osc%xi <= 0 .and. r(1) <= 1 .and. r(2) >= 1) then
            call complain(group, 'r_min', line, message, &
               'r = 1 must not be in the window when xi = 0 (resonance without damping)')
         else if (.not. (d(1) >= 1.0e-12_wp .and. d(1) <= 1.0e12_wp)) then
            call complain(group, 'clearance_min', line, message)
         else if (.not. (d(2) > d(1) .and. d(2) <= 1.0e12_wp)) then
            call complain(group, 'clearance_max', line, message, &
               'clearance_min is '//shown(d(1), 'g0.10'))
         else if (zone%lines < 5 .or. zone%lines > 129) then
            call complain(group, 'lines', line, message)
         else if (zone%guesses < 0 .or. zone%guesses > 100000) then
            call complain(group, 'guesses', line, message)
         else if (zone%points < 100 .or. zone%points > 200000) then
            call complain(group, 'max_points', line, message)
         end if
      end associate
   end subroutine check_window

end module vi_case_zone
