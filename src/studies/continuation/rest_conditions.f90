!> The conditions of motions with rest, with their gradients with respect to the unknowns, r, log D.
module vi_rest_conditions
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use vi_frame, only: condition_at, condition_type, edge, flip, fold, frame_type, grazing, &
      neimark_sacker, rest_splits, rest_vanishes, zero_approach
   use vi_kinds, only: wp
   use vi_rest_family, only: measure_type, rest_period, rest_period_type, rest_stability
   implicit none (type, external)
   private

   public :: measure_in_period, rest_condition, rest_conditions, touching_in

contains

   !> The values of all conditions of a motion with rest; -1 where its symbols cannot be followed.
   pure subroutine rest_conditions(frame, unknowns, c, values, found)
      !> The family, its repetitions, and its edges.
      type(frame_type), intent(in) :: frame
      !> Phase and asinh(v/D) at the release, phases of the first impacts; r, log(D), xi, mu, R1,
      !! R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> (m) Value of each condition, positive where it is met.
      real(wp), intent(out) :: values(:)
      !> (m) The conditions; grazing with its wall and flight.
      type(condition_type), intent(out) :: found(:)
      type(rest_period_type) :: period
      type(measure_type) :: measure
      integer :: j

      call rest_period(frame%rest, unknowns, c, period)
      do j = 1, size(values)
         found(j) = condition_at(frame, j)
         if (period%right .and. found(j)%kind == grazing) then
            found(j)%side = period%touched(found(j)%index)
            found(j)%share = period%touched_at(found(j)%index)
            if (found(j)%share < 0) found(j)%kind = rest_splits
         end if
         measure = measure_in_period(period, c, found(j))
         values(j) = measure%value
         if (.not. (period%right .or. found(j)%kind == edge)) values(j) = -1
      end do
   end subroutine rest_conditions

   !> The value of one condition of a motion with rest; not a number where its symbols cannot be
   !> followed.
   pure real(wp) function rest_condition(frame, unknowns, c, condition) result(value)
      !> The family.
      type(frame_type), intent(in) :: frame
      !> Phase and asinh(v/D) at the release, phases of the first impacts; r, log(D), xi, mu, R1,
      !! R2.
      real(wp), intent(in) :: unknowns(:), c(:)
      !> The condition.
      type(condition_type), intent(in) :: condition
      type(rest_period_type) :: period
      type(measure_type) :: measure

      call rest_period(frame%rest, unknowns, c, period, touching_in([condition]))
      value = ieee_value(1.0_wp, ieee_quiet_nan)
      if (.not. period%right) return
      measure = measure_in_period(period, c, condition)
      value = measure%value
   end function rest_condition

   !> The symbol in which one of the conditions has a bounce touch the wall; 0 if there is none.
   pure integer function touching_in(conditions) result(symbol)
      !> The conditions that are zero.
      type(condition_type), intent(in) :: conditions(:)

      symbol = findloc(conditions%kind == grazing .and. conditions%share > 1, .true., dim=1)
      if (symbol > 0) symbol = conditions(symbol)%index
   end function touching_in

   !> The value of a condition in a period, and its gradient; the gradients of fold, flip and
   !! Neimark-Sacker are left at 0.
   pure type(measure_type) function measure_in_period(period, c, condition) result(measure)
      !> The period; `right` may be false, then only edges have a value.
      type(rest_period_type), intent(in) :: period
      !> r, log(D), xi, mu, R1, R2
      real(wp), intent(in) :: c(:)
      !> The condition.
      type(condition_type), intent(in) :: condition
      real(wp) :: stability(3)

      associate (i => condition%index)
         if (condition%kind == edge) then
            measure%value = condition%side*(c(i) - condition%bound)
            if (i <= 2) measure%by(size(period%approach) + 2 + i) = condition%side
            return
         end if
         if (.not. period%right) return
         select case (condition%kind)
         case (fold, flip, neimark_sacker)
            stability = rest_stability(period)
            measure%value = stability(condition%kind)
         case (zero_approach)
            measure = period%approach(i)
         case (grazing, rest_splits)
            measure = period%gap(i)
         case (rest_vanishes)
            measure = period%rest(i)
         case default
            continue
         end select
      end associate
   end function measure_in_period

end module vi_rest_conditions
