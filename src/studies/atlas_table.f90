!> An atlas as plain arrays: its zones one after the other, and what became of the survey's points.
module vi_atlas_table
   use vi_atlas, only: atlas_request_type, atlas_type, find_atlas
   use vi_kinds, only: wp
   use vi_status, only: stat
   use vi_survey_outcome, only: beyond, periodic
   use vi_zone_table, only: append_zone
   implicit none (type, external)
   private

   public :: atlas_arrays

contains

   !> `find_atlas` between arrays.
   subroutine atlas_arrays(request, patterns, sheets, vertices, unknowns, labels, loops, inside, &
      places, outcomes, letters, sizes, status, tally)
      type(atlas_request_type), intent(in) :: request
      !> (max_impacts, room): letters of the pattern of each sheet, then zeros.
      integer, intent(inout) :: patterns(:, :)
      !> (9, room): cycles, whether symmetric, vertices, loops, then as `work` of `zone_arrays`.
      integer, intent(inout) :: sheets(:, :)
      !> As of `zone_arrays`, sheet by sheet.
      real(wp), intent(inout) :: vertices(:, :), unknowns(:, :)
      integer, intent(inout) :: labels(:, :), loops(:, :)
      real(wp), intent(inout) :: inside(:, :)
      !> (2, survey): r, D.
      real(wp), intent(out) :: places(:, :)
      !> (4, survey): outcome as in vi_survey_outcome; of a periodic motion cycles and letters, and
      !> whether it lies in a zone of its pattern.
      integer, intent(out) :: outcomes(:, :)
      !> Of the motions of all points, one after the other.
      integer, intent(inout) :: letters(:)
      !> How many there are of sheets, vertices, loops and letters.
      integer, intent(out) :: sizes(4)
      !> `stat%more_events` if there is no room for as many: then the sizes alone are right.
      integer, intent(out) :: status
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(atlas_type) :: atlas
      integer :: i, n, n_loops, first, first_loop

      places = 0
      outcomes = 0
      call find_atlas(request, atlas, tally)
      sizes = sizes_of(atlas)
      status = stat%more_events
      if (any(sizes > [size(sheets, 2), size(vertices, 2), size(loops, 2), size(letters)])) return
      status = stat%ok
      n = 0
      n_loops = 0
      do i = 1, size(atlas%sheets)
         associate (sheet => atlas%sheets(i), zone => atlas%sheets(i)%zone)
            first = n
            first_loop = n_loops
            call append_zone(zone, vertices, unknowns, labels, n, loops, inside, n_loops, status)
            patterns(:, i) = 0
            patterns(:size(sheet%pattern%sides), i) = sheet%pattern%sides
            sheets(:, i) = [sheet%pattern%cycles, merge(1, 0, sheet%symmetric), n - first, &
               n_loops - first_loop, zone%nodes, zone%steps, zone%untraced, zone%lines]
         end associate
      end do
      call write_points(atlas, places, outcomes, letters)
   end subroutine atlas_arrays

   !> How many sheets, vertices, loops and letters of points an atlas has.
   pure function sizes_of(atlas) result(sizes)
      type(atlas_type), intent(in) :: atlas
      integer :: sizes(4)
      integer :: i, j

      sizes = [size(atlas%sheets), 0, 0, 0]
      do i = 1, size(atlas%sheets)
         associate (zone => atlas%sheets(i)%zone)
            sizes(2:3) = sizes(2:3) + [sum([(zone%loops(j)%n, j=1, zone%n)]), zone%n]
         end associate
      end do
      do i = 1, size(atlas%points)
         if (is_named(atlas, i)) sizes(4) = sizes(4) + size(atlas%points(i)%letters)
      end do
   end function sizes_of

   !> Whether the motion of a point is known by its pattern.
   pure logical function is_named(atlas, i)
      type(atlas_type), intent(in) :: atlas
      integer, intent(in) :: i

      associate (point => atlas%points(i))
         is_named = point%outcome == periodic .or. point%outcome == beyond
      end associate
   end function is_named

   !> What became of the points of the survey.
   pure subroutine write_points(atlas, places, outcomes, letters)
      type(atlas_type), intent(in) :: atlas
      real(wp), intent(inout) :: places(:, :)
      integer, intent(inout) :: outcomes(:, :), letters(:)
      integer :: i, n, found

      n = 0
      found = 0
      do i = 1, size(atlas%points)
         associate (point => atlas%points(i))
            places(:, i) = [point%r, point%clearance]
            outcomes(1, i) = point%outcome
            if (.not. is_named(atlas, i)) cycle
            outcomes(2:3, i) = [point%cycles, size(point%letters)]
            letters(n + 1:n + size(point%letters)) = point%letters
            n = n + size(point%letters)
            if (.not. point%found) cycle
            found = found + 1
            outcomes(4, i) = merge(1, 0, atlas%explained(found))
         end associate
      end do
   end subroutine write_points

end module vi_atlas_table
