!> Assigns the motions of a chart to slots, so that each slot is continuous over the grid.
!!
!! A sheet is a set of motions at connected points, at most one at each point. Two motions at
!! neighbouring points belong together if each is the nearest of all motions at its point to the
!! other. Sheets with more admissible stable motions are placed first, then those with more
!! admissible ones, then the larger ones. Each slot holds sheets that do not touch, as far as there
!! is room.
module vi_chart_slots
   use vi_grid_continuation, only: admissible, admissible_stable, solved, steps
   use vi_kinds, only: wp
   use vi_likeness, only: distance
   use vi_pattern, only: pattern_type
   implicit none (type, external)
   private

   public :: assign_slots

   !> Motions at neighbouring points that are further apart than this do not belong together.
   real(wp), parameter :: reach = 0.5_wp

   !> The sheets: members (3, :) = i, j, k in the order they were found, and where each begins.
   type :: sheets_type
      integer, allocatable :: members(:, :), first(:)
      !> (3, s): admissible and stable motions, admissible ones, all.
      integer, allocatable :: sizes(:, :)
      !> The sheet of each motion (keep, m, n), 0 if none yet, and the newest one that has a motion
      !! at a point (m, n).
      integer, allocatable :: sheet_of(:, :, :), stamp(:, :)
      !> Sheets, and members of all of them.
      integer :: n = 0, last = 0
   end type sheets_type

contains

   !> The slots of all motions; 0 for a motion for which there is no room.
   pure subroutine assign_slots(pattern, scale, unknowns, ranks, counts, capacity, slots)
      !> Sides of the N impacts, and the load cycles k of a period.
      type(pattern_type), intent(in) :: pattern
      !> (m, n): `length_scale` of each point
      real(wp), intent(in) :: scale(:, :)
      !> (2N, keep, m, n): x_i and theta_i of the motions found
      real(wp), intent(in) :: unknowns(:, :, :, :)
      !> (keep, m, n) rank of each motion, and (m, n) number of motions at each point
      integer, intent(in) :: ranks(:, :, :), counts(:, :)
      !> Number of slots.
      integer, intent(in) :: capacity
      !> (keep, m, n): slot of each motion
      integer, intent(out) :: slots(:, :, :)
      type(sheets_type) :: sheets
      integer :: holder(capacity, size(counts, 1), size(counts, 2))
      integer, allocatable :: order(:)
      integer :: s

      call find_sheets(pattern, scale, unknowns, ranks, counts, sheets)
      order = by_size(sheets%sizes(:, :sheets%n))
      slots = 0
      holder = 0
      do s = 1, sheets%n
         associate (a => sheets%first(order(s)), b => sheets%first(order(s) + 1) - 1)
            call place(sheets%members(:, a:b), ranks, holder, slots)
         end associate
      end do
   end subroutine assign_slots

   !> All sheets, those with a motion of higher rank first.
   pure subroutine find_sheets(pattern, scale, unknowns, ranks, counts, sheets)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> (m, n) and (2N, keep, m, n), as in `assign_slots`.
      real(wp), intent(in) :: scale(:, :), unknowns(:, :, :, :)
      !> (keep, m, n) and (m, n), as in `assign_slots`.
      integer, intent(in) :: ranks(:, :, :), counts(:, :)
      !> The sheets.
      type(sheets_type), intent(out) :: sheets
      integer :: rank, i, j, k

      allocate (sheets%members(3, sum(counts)), sheets%first(sum(counts) + 1), sheets%sizes(3, &
         sum(counts)))
      allocate (sheets%sheet_of, mold=ranks)
      allocate (sheets%stamp, mold=counts)
      sheets%sheet_of = 0
      sheets%stamp = 0
      do rank = admissible_stable, solved, -1
         do k = 1, size(counts, 2)
            do j = 1, size(counts, 1)
               do i = 1, counts(j, k)
                  if (sheets%sheet_of(i, j, k) > 0 .or. ranks(i, j, k) /= rank) cycle
                  sheets%n = sheets%n + 1
                  sheets%first(sheets%n) = sheets%last + 1
                  call join(sheets, i, j, k)
                  call grow(pattern, scale, unknowns, ranks, counts, sheets)
               end do
            end do
         end do
      end do
      sheets%first(sheets%n + 1) = sheets%last + 1
   end subroutine find_sheets

   !> Grows the newest sheet from its first member over all neighbours.
   pure subroutine grow(pattern, scale, unknowns, ranks, counts, sheets)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> (m, n) and (2N, keep, m, n), as in `assign_slots`.
      real(wp), intent(in) :: scale(:, :), unknowns(:, :, :, :)
      !> (keep, m, n) and (m, n), as in `assign_slots`.
      integer, intent(in) :: ranks(:, :, :), counts(:, :)
      !> In and out: motions are added to the newest sheet.
      type(sheets_type), intent(inout) :: sheets
      integer :: next, side, i, j, k, jj, kk, other, sizes(3)

      next = sheets%last
      sizes = 0
      do while (next <= sheets%last)
         i = sheets%members(1, next)
         j = sheets%members(2, next)
         k = sheets%members(3, next)
         sizes = sizes + merge(1, 0, ranks(i, j, k) >= [admissible_stable, admissible, solved])
         do side = 1, 4
            jj = j + steps(1, side)
            kk = k + steps(2, side)
            if (jj < 1 .or. kk < 1 .or. jj > size(counts, 1) .or. kk > size(counts, 2)) cycle
            if (sheets%stamp(jj, kk) == sheets%n) cycle
            other = closest(pattern, scale(j, k), unknowns(:, i, j, k), &
               unknowns(:, :counts(jj, kk), jj, kk))
            if (other == 0) cycle
            if (sheets%sheet_of(other, jj, kk) > 0) cycle
            if (closest(pattern, scale(j, k), unknowns(:, other, jj, kk), &
               unknowns(:, :counts(j, k), j, k)) == i) call join(sheets, other, jj, kk)
         end do
         next = next + 1
      end do
      sheets%sizes(:, sheets%n) = sizes
   end subroutine grow

   !> Adds a motion to the newest sheet.
   pure subroutine join(sheets, i, j, k)
      !> In and out: the sheets.
      type(sheets_type), intent(inout) :: sheets
      !> Number of the motion at the point, and the point.
      integer, intent(in) :: i, j, k

      sheets%last = sheets%last + 1
      sheets%members(:, sheets%last) = [i, j, k]
      sheets%sheet_of(i, j, k) = sheets%n
      sheets%stamp(j, k) = sheets%n
   end subroutine join

   !> Number of the nearest of several motions; 0 if none is near.
   pure integer function closest(pattern, scale, unknowns, others) result(best)
      !> The pattern.
      type(pattern_type), intent(in) :: pattern
      !> Unit of positions; (2N) the motion; (2N, m) the others.
      real(wp), intent(in) :: scale, unknowns(:), others(:, :)
      real(wp) :: least, item
      integer :: i

      best = 0
      least = reach
      do i = 1, size(others, 2)
         item = distance(pattern, scale, unknowns, others(:, i))
         if (item >= least) cycle
         least = item
         best = i
      end do
   end function closest

   !> The order of sheets, the largest first; equal ones keep their order.
   pure function by_size(sizes) result(order)
      !> (3, sheets) As in `sheets_type`.
      integer, intent(in) :: sizes(:, :)
      integer :: order(size(sizes, 2))
      integer :: s, t

      do s = 1, size(order)
         t = s
         do while (t > 1)
            if (.not. larger(sizes(:, s), sizes(:, order(t - 1)))) exit
            order(t) = order(t - 1)
            t = t - 1
         end do
         order(t) = s
      end do
   end function by_size

   !> Whether one sheet comes before another.
   pure logical function larger(one, other)
      !> Their sizes, as in `sheets_type`.
      integer, intent(in) :: one(3), other(3)
      integer :: i

      larger = .false.
      do i = 1, 3
         larger = one(i) > other(i)
         if (one(i) /= other(i)) return
      end do
   end function larger

   !> Puts a sheet into the first slot in which it neither overlaps nor touches another sheet;
   !! otherwise into the first one in which it overlaps none. Otherwise it is divided among slots.
   pure subroutine place(members, ranks, holder, slots)
      !> (3, p) i, j, k of its motions; (keep, m, n) ranks of all motions.
      integer, intent(in) :: members(:, :), ranks(:, :, :)
      !> (capacity, m, n): the motion that holds a slot, 0 if none.
      integer, intent(inout) :: holder(:, :, :)
      !> (keep, m, n) In and out: the slot of each motion.
      integer, intent(inout) :: slots(:, :, :)
      logical, dimension(size(holder, 1)) :: taken, touched
      integer :: t, p, side, slot

      taken = .false.
      touched = .false.
      do p = 1, size(members, 2)
         associate (j => members(2, p), k => members(3, p))
            taken = taken .or. holder(:, j, k) > 0
            do side = 1, 4
               touched = touched .or. holder(:, min(max(j + steps(1, side), 1), size(holder, 2)), &
                  min(max(k + steps(2, side), 1), size(holder, 3))) > 0
            end do
         end associate
      end do
      slot = findloc(taken .or. touched, .false., 1)
      if (slot == 0) slot = findloc(taken, .false., 1)
      do p = 1, size(members, 2)
         associate (i => members(1, p), j => members(2, p), k => members(3, p))
            t = slot
            if (t == 0) t = findloc(holder(:, j, k), 0, 1)
            if (t == 0) t = weakest(ranks(:, j, k), holder(:, j, k), ranks(i, j, k))
            if (t == 0) cycle
            if (holder(t, j, k) > 0) slots(holder(t, j, k), j, k) = 0
            holder(t, j, k) = i
            slots(i, j, k) = t
         end associate
      end do
   end subroutine place

   !> The last slot whose motion has the lowest rank, if that is below a given rank; otherwise 0.
   pure integer function weakest(ranks, holder, rank) result(slot)
      !> (keep) ranks of the motions at a point; (capacity) the motion that holds each slot; the
      !! rank in question.
      integer, intent(in) :: ranks(:), holder(:), rank

      slot = minloc(ranks(holder), 1, back=.true.)
      if (ranks(holder(slot)) >= rank) slot = 0
   end function weakest

end module vi_chart_slots
