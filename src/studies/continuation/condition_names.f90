!> The standard names of the conditions that bound the motions of a branch or a zone.
module vi_condition_names
   use vi_motion_family, only: contact_vanishes, edge, event_vanishes, events_meet, &
      flight_vanishes, flip, fold, grazing, joint, neimark_sacker, repetition, rest_splits, &
      rest_vanishes, stick_begins, stick_vanishes, together, zero_approach
   implicit none (type, external)
   private

   public :: condition_detail, condition_name

   !> Fixed lengths of names and details: gfortran keeps the length of a result of deferred length
   !! in one place for all threads.
   integer, parameter, public :: name_length = 16, detail_length = 24

   !> The parameters in their order in the core.
   character(6), parameter :: parameters(6) = [character(6) :: 'r', 'd K/F0', 'xi', 'mu', 'R1', &
      'R2']

contains

   !> The type of a condition that is zero.
   pure function condition_name(kind, index, symmetric, mirrored) result(name)
      !> Kind and index of the condition, as in vi_motion_family.
      integer, intent(in) :: kind, index
      !> Whether the family consists of symmetric motions.
      logical, intent(in) :: symmetric
      !> Whether repetition number 1 is that of a motion that is its own mirror image.
      logical, intent(in) :: mirrored
      character(name_length) :: name

      select case (kind)
      case (fold)
         name = 'fold'
         if (index > 0) name = merge('pitchfork   ', 'branch_point', index == together)
      case (flip)
         name = merge('pitchfork', 'flip     ', symmetric .and. index == 0)
      case (neimark_sacker)
         name = 'neimark_sacker'
      case (zero_approach)
         name = 'zero_approach'
      case (grazing)
         name = 'grazing'
      case (repetition)
         name = merge('pitchfork', 'flip     ', mirrored .and. index == 1)
      case (edge)
         name = 'bound'
      case (rest_vanishes)
         name = 'rest_vanishes'
      case (rest_splits)
         name = 'rest_splits'
      case (stick_begins)
         name = 'stick_begins'
      case (stick_vanishes)
         name = 'stick_vanishes'
      case (contact_vanishes)
         name = 'contact_vanishes'
      case (flight_vanishes)
         name = 'flight_vanishes'
      case (events_meet)
         name = 'simultaneous'
      case (event_vanishes)
         name = 'event_vanishes'
      case (joint)
         name = 'joint'
      case default
         name = 'unknown'
      end select
   end function condition_name

   !> The detail of a condition: which flight touches which wall, which impact has no approach
   !! speed, which parameter is at a bound.
   pure function condition_detail(kind, index, side) result(detail)
      !> Kind, index and side of the condition, as in vi_motion_family.
      integer, intent(in) :: kind, index, side
      character(detail_length) :: detail

      select case (kind)
      case (grazing)
         detail = 'flight '//number_text(index)//' touches '//merge('R', 'L', side > 0)
      case (zero_approach)
         detail = 'impact '//number_text(index)
      case (edge)
         detail = trim(merge('lowest ', 'highest', side > 0))//' '//trim(parameters(index))
      case default
         detail = ''
      end select
   end function condition_detail

   !> A whole number below 100.
   pure function number_text(number) result(text)
      !> From 0 to 99.
      integer, intent(in) :: number
      character(merge(2, 1, number >= 10)) :: text

      text = achar(iachar('0') + number/10)//achar(iachar('0') + mod(number, 10))
      if (number < 10) text = achar(iachar('0') + number)
   end function number_text

end module vi_condition_names
