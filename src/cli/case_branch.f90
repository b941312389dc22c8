!> The case of a &branch group, checked.
module vi_case_branch
   use vi_case_motion, only: take_motion
   use vi_case_type, only: case_type
   use vi_chain, only: periodic_chain
   use vi_keys, only: complain, read_group
   use vi_kinds, only: wp
   use vi_motion, only: motion_type
   use vi_namelist, only: group_type
   use vi_orbit, only: by_clearance, by_r, by_right, by_xi, most_impacts, n_parameters
   use vi_periodic, only: linear_system_type
   use vi_raw, only: raw_type
   use vi_status, only: stat
   use vi_text, only: lower, shown, whole
   implicit none (type, external)
   private

   public :: parameter_place, take_branch, take_start
   public :: least, most, parameters

   !> What a branch can follow, in the order of the core, and their ranges.
   character(11), parameter :: parameters(7) = [character(11) :: 'r', 'clearance', 'xi', 'mu', &
      'R1', 'R2', 'restitution']
   real(wp), parameter :: least(7) = [1.0e-6_wp, 1.0e-12_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: most(7) = [1.0e6_wp, 1.0e12_wp, nearest(1.0_wp, -1.0_wp), 1.0e6_wp, &
      1.0_wp, 1.0_wp, 1.0_wp]
   character(26), parameter :: ranges(7) = [character(26) :: '1e-6 <= r <= 1e6', &
      '1e-12 <= clearance <= 1e12', '0 <= xi < 1', '0 <= mu <= 1e6', '0 <= R1 <= 1', &
      '0 <= R2 <= 1', '0 <= restitution <= 1']

contains

   !> Reads the &motion before a &branch: it starts from there.
   subroutine take_start(groups, raw, case, line, message)
      !> The group and all before it.
      type(group_type), intent(in) :: groups(:)
      type(raw_type), intent(inout) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      do i = size(groups) - 1, 1, -1
         if (groups(i)%name == 'motion' .or. groups(i)%name == 'system') exit
      end do
      if (groups(i)%name == 'system') then
         message = '&branch: no &motion of this &system stands before it'
         return
      end if
      call read_group(groups(i), raw, line, message)
      if (len(message) == 0) call take_motion(groups(i), raw, case, line, message)
      if (len(message) > 0) return
      line = groups(size(groups))%line
      if (size(case%phases) > most_impacts) then
         message = '&branch: the &motion before it has '//whole(size(case%phases))// &
            ' impacts; must have at most '//whole(most_impacts)
      else if (case%own_restitution) then
         message = '&branch: the &motion before it has impact_restitution; must be without'
      else if (case%single) then
         message = '&branch: the &motion before it has precision = ''single''; must be ''double'''
      end if
   end subroutine take_start

   !> Checks the variables of &branch and puts them into a case that has its motion.
   subroutine take_branch(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: i

      case%bounds = [raw%branch%low, raw%branch%high]
      case%longest_step = raw%branch%longest_step
      case%max_points = raw%branch%max_points
      do i = 1, size(parameters)
         if (lower(parameters(i)) == lower(raw%branch%parameter)) exit
      end do
      if (i > size(parameters)) then
         call complain(group, 'parameter', line, message)
         return
      end if
      case%parameter = trim(parameters(i))
      if (i > n_parameters .and. abs(case%osc%restitution(1) - case%osc%restitution(2)) > 0) then
         call complain(group, 'parameter', line, message, &
            '''restitution'' needs equal restitution on both walls')
      else if (.not. (case%longest_step >= 1.0e-6_wp .and. case%longest_step <= 1)) then
         call complain(group, 'longest_step', line, message)
      else if (case%max_points < 10 .or. case%max_points > 100000) then
         call complain(group, 'max_points', line, message)
      else
         call check_bounds(group, case, i, line, message)
      end if
   end subroutine take_branch

   !> The bounds are in the range of the parameter, with the motion's own value between them.
   subroutine check_bounds(group, case, place, line, message)
      type(group_type), intent(in) :: group
      type(case_type), intent(in) :: case
      !> Of the parameter.
      integer, intent(in) :: place
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      real(wp) :: start(2)

      start = start_value(case, place)
      associate (low => case%bounds(1), high => case%bounds(2), &
         resonance => case%osc%xi <= 0)
         if (.not. (low >= least(place) .and. low <= start(1))) then
            call complain(group, 'low', line, message, limits(place, start))
         else if (.not. (high <= most(place) .and. high >= start(2) .and. high > low)) then
            call complain(group, 'high', line, message, limits(place, start))
         else if ((place == by_r .and. resonance .and. low <= 1 .and. high >= 1) .or. &
            (place == by_xi .and. low <= 0 .and. abs(case%r - 1) <= 0)) then
            call complain(group, 'low', line, message, &
               'r = 1 with xi = 0 (resonance without damping) must not be between low and high')
         end if
      end associate
   end subroutine check_bounds

   !> What is allowed for the bounds of a parameter.
   pure function limits(place, start) result(text)
      integer, intent(in) :: place
      real(wp), intent(in) :: start(2)
      character(len_trim(padded_limits(place, start))) :: text

      text = padded_limits(place, start)
   end function limits

   !> The same with blanks behind it.
   pure function padded_limits(place, start) result(text)
      integer, intent(in) :: place
      real(wp), intent(in) :: start(2)
      character(120) :: text

      text = ranges(place)
      if (start(1) <= start(2)) text = trim(text)//', and the motion has '//trim( &
         parameters(place))//' = '//shown(start(1), 'g0.10')
   end function padded_limits

   !> Where the parameter starts: at least and at most.
   function start_value(case, place) result(value)
      type(case_type), intent(in) :: case
      integer, intent(in) :: place
      real(wp) :: value(2)
      type(linear_system_type) :: system
      type(motion_type) :: motion

      select case (place)
      case (by_r)
         value = case%r
      case (by_clearance)
         value = case%clearance
         if (case%motion_kind /= 'periodic') return
         ! the clearance follows from the phases; without a motion any bounds will do
         call periodic_chain(case%osc, case%r, case%pattern, case%restitution, case%phases, &
            case%acceptance, .false., system, motion)
         value = [huge(1.0_wp), -huge(1.0_wp)]
         if (motion%status == stat%ok) value = motion%clearance
      case (by_xi)
         value = case%osc%xi
      case (by_xi + 1)
         value = case%osc%mu
      case default
         value = case%osc%restitution(merge(2, 1, place == by_right + 1))
      end select
   end function start_value

   !> The place of a parameter in the core, and whether it stands for both walls.
   pure subroutine parameter_place(name, place, tied)
      character(*), intent(in) :: name
      integer, intent(out) :: place
      logical, intent(out) :: tied

      place = findloc(parameters == name, .true., 1)
      tied = place > n_parameters
      if (tied) place = by_right
   end subroutine parameter_place

end module vi_case_branch
