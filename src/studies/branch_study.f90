!> The study &branch: motions along a parameter, from those of a &motion.
module vi_branch_study
   use vi_case, only: case_type
   use vi_chain, only: periodic_chain
   use vi_common_keys, only: parameter_place, parameter_range, parameter_takes, parameter_words, &
      parameters, resonance
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_motion, only: motion_type
   use vi_motion_study, only: check_motion, motion_request, motion_request_type
   use vi_orbit, only: by_clearance, by_r, by_right, by_xi, most_impacts
   use vi_periodic, only: linear_system_type
   use vi_status, only: stat
   use vi_text, only: shown, whole
   use vi_values, only: values_type
   implicit none (type, external)
   private

   public :: check_branch, check_branch_start

   type(key_type), parameter, public :: branch_keys(*) = [ &
      key_type('parameter', a_word, words=parameter_words, takes=parameter_takes, &
      meaning='what changes'), &
      key_type('low', takes='a number, at most the value that the motion has', &
      meaning='its lower bound'), &
      key_type('high', takes='a number above low, at least the value that the motion has', &
      meaning='its upper bound'), &
      key_type('longest_step', default='0.05', low=1.0e-6_wp, high=1.0_wp, &
      meaning='along the branch, the bounds being 0 and 1'), &
      key_type('max_points', a_whole, default='4000', low=10.0_wp, high=1.0e5_wp, &
      meaning='points each way, after which it is cut short')]

contains

   !> Checks the &motion that a branch starts from.
   subroutine check_branch_start(case, line)
      !> With `start`, which keeps the fault.
      type(case_type), intent(inout) :: case
      !> Of the group &branch.
      integer, intent(in) :: line
      type(motion_request_type) :: wanted

      call check_motion(case%osc, case%start)
      if (len(case%start%fault) > 0) return
      call motion_request(case%osc, case%start, wanted)
      if (size(wanted%phases) > most_impacts) then
         call blame(case%start, 'has '//whole(size(wanted%phases))//' impacts; must have at most ' &
            //whole(most_impacts), line)
      else if (case%start%has('impact_restitution')) then
         call blame(case%start, 'has impact_restitution; must be without', line)
      else if (wanted%single) then
         call blame(case%start, 'has precision = ''single''; must be ''double''', line)
      end if
   end subroutine check_branch_start

   !> Keeps a fault of the start.
   pure subroutine blame(start, text, line)
      !> The group.
      type(values_type), intent(inout) :: start
      !> What is wrong with the motion, and what must be.
      character(*), intent(in) :: text
      !> Of the group &branch.
      integer, intent(in) :: line

      start%fault = '&branch: the &motion before it '//text
      start%fault_line = line
   end subroutine blame

   !> Checks what depends on several keys, and on the motion that the branch starts from.
   subroutine check_branch(case)
      !> With `start`.
      type(case_type), intent(inout) :: case
      real(wp) :: start(2), low, high, least, most
      character(40) :: text
      character(:), allocatable :: limits
      integer :: place, core_place
      logical :: tied

      if (len(case%study%fault) > 0) return
      place = findloc(parameters == case%study%word('parameter'), .true., 1)
      call parameter_place(trim(parameters(place)), core_place, tied)
      if (tied .and. abs(case%osc%restitution(1) - case%osc%restitution(2)) > 0) call &
         case%study%refuse('parameter', '''restitution'' needs equal restitution on both walls')
      if (len(case%study%fault) > 0) return
      start = start_value(case, place)
      low = case%study%number('low')
      high = case%study%number('high')
      call parameter_range(place, least, most, text)
      limits = trim(text)
      if (start(1) <= start(2)) limits = limits//', and the motion has '//trim(parameters(place)) &
         //' = '//shown(start(1), 'g0.10')
      if (.not. (low >= least .and. low <= start(1))) then
         call case%study%refuse('low', limits)
      else if (.not. (high <= most .and. high >= start(2) .and. high > low)) then
         call case%study%refuse('high', limits)
      else if ((place == by_r .and. case%osc%xi <= 0 .and. low <= 1 .and. high >= 1) .or. &
         (place == by_xi .and. low <= 0 .and. abs(case%r - 1) <= 0)) then
         call case%study%refuse('low', resonance//'between low and high')
      end if
   end subroutine check_branch

   !> Where the parameter starts: at least and at most.
   function start_value(case, place) result(value)
      !> With `start`.
      type(case_type), intent(in) :: case
      !> Of the parameter among `parameters`.
      integer, intent(in) :: place
      real(wp) :: value(2)
      type(linear_system_type) :: system
      type(motion_request_type) :: wanted
      type(motion_type) :: motion

      select case (place)
      case (by_r)
         value = case%r
      case (by_clearance)
         call motion_request(case%osc, case%start, wanted)
         value = wanted%clearance
         if (wanted%kind /= 'periodic') return
         ! the clearance follows from the phases; without a motion any bounds will do
         call periodic_chain(case%osc, case%r, wanted%pattern, wanted%restitution, wanted%phases, &
            wanted%acceptance, .false., system, motion)
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

end module vi_branch_study
