!> Lattice lines over a window of the plane (r, log D), close enough together not to miss zones.
!!
!! In a window about r = 1 of the size of the charts of the 1983 paper they are evenly spaced. A
!! larger window has more lines, and those of constant r are closest where zones are narrow: about
!! the resonance r = 1, and at small r, where the values r = 1/n are about r**2 apart. A further
!! line lies on each of these values.
module vi_lattice
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: density, even_lattice, lattice_of, lattice_type, line_spacing, nearest_lines, &
      new_lattice

   !> Coordinates of lines in increasing order, 0 at the lower end of the window.
   type :: axis_type
      real(wp), allocatable :: at(:)
   end type axis_type

   !> The lines of both directions.
   type :: lattice_type
      !> The lines of constant r, and of constant D.
      type(axis_type) :: axes(2)
   end type lattice_type

   !> Spacings with 17 lines: of log D; of r, over its distance from 1; of r, over r**2.
   real(wp), parameter :: by_ratio = log(100.0_wp)/16, by_resonance = 0.27_wp, by_order = 0.5_wp
   !> Distance from the resonance within which the spacing hardly decreases further.
   real(wp), parameter :: width = 0.1_wp
   !> Largest number of spacings, over the number requested.
   integer, parameter :: most = 8

contains

   !> The lattice of a window, with at least the requested number of lines in each direction.
   pure function new_lattice(lines, window, scale) result(lattice)
      !> Least number of lines in each direction, at least 2.
      integer, intent(in) :: lines
      !> Lowest and highest r, lowest and highest log D, and the units of the lines.
      real(wp), intent(in) :: window(4), scale(2)
      type(lattice_type) :: lattice

      lattice%axes(1)%at = with_resonances(r_lines(lines, window(1), window(2)), window(1), &
         window(2))*((window(2) - window(1))/scale(1))
      lattice%axes(2)%at = even(needed((window(4) - window(3))/by_ratio, lines))* &
         ((window(4) - window(3))/scale(2))
   end function new_lattice

   !> The evenly spaced lattice of the unit square.
   pure function even_lattice(lines, rows) result(lattice)
      !> Number of lines in each direction, at least 2.
      integer, intent(in) :: lines
      !> Number of lines along which the second coordinate is constant, if it differs.
      integer, intent(in), optional :: rows
      type(lattice_type) :: lattice

      lattice%axes(1)%at = even(lines)
      lattice%axes(2)%at = lattice%axes(1)%at
      if (present(rows)) lattice%axes(2)%at = even(rows)
   end function even_lattice

   !> The two lines through a place.
   pure function lattice_of(at) result(lattice)
      !> Its coordinates.
      real(wp), intent(in) :: at(2)
      type(lattice_type) :: lattice

      lattice%axes(1)%at = [at(1)]
      lattice%axes(2)%at = [at(2)]
   end function lattice_of

   !> Places of the lines of constant r from 0 to 1: evenly spaced if that is dense enough,
   !! otherwise evenly in the integral of the density.
   pure function r_lines(lines, low, high) result(at)
      !> Least number of lines, at least 2.
      integer, intent(in) :: lines
      !> Lowest and highest r.
      real(wp), intent(in) :: low, high
      real(wp), allocatable :: at(:)
      real(wp) :: a, b, middle, level
      integer :: i, j

      if ((high - low)/16*maxval(density([low, min(max(low, 1.0_wp), high)])) <= 1) then
         at = even(lines)
         return
      end if
      at = even(needed(total(high) - total(low), lines))
      do i = 2, size(at) - 1
         level = total(low) + at(i)*(total(high) - total(low))
         a = low
         b = high
         do j = 1, 50
            middle = (a + b)/2
            if (total(middle) < level) then
               a = middle
            else
               b = middle
            end if
         end do
         at(i) = (a - low)/(high - low)
      end do
   end function r_lines

   !> The lines, and one on each resonance r = 1/n: with little damping, zones are narrow there.
   !! Where there are more resonances than lines, the lines alone.
   pure function with_resonances(at, low, high) result(all)
      !> Places of the lines of constant r from 0 to 1.
      real(wp), intent(in) :: at(:)
      !> Lowest and highest r.
      real(wp), intent(in) :: low, high
      real(wp), allocatable :: all(:)
      !> Lines nearer to each other than this are the same.
      real(wp), parameter :: same = 1.0e-6_wp
      real(wp) :: place
      integer :: i, n

      all = at
      if (1/low - 1/high > size(at)) return
      do n = floor(1/low), ceiling(1/high), -1
         place = (1.0_wp/n - low)/(high - low)
         if (minval(abs(all - place)) < same) cycle
         i = count(all < place)
         all = [all(:i), place, all(i + 1:)]
      end do
   end function with_resonances

   !> Number of spacings of 17 lines per unit of r.
   elemental real(wp) function density(r)
      !> Frequency ratio.
      real(wp), intent(in) :: r

      density = 1/(by_resonance*hypot(width, r - 1)) + 1/(by_order*r**2)
   end function density

   !> Integral of `density` over r.
   pure real(wp) function total(r)
      !> Frequency ratio.
      real(wp), intent(in) :: r

      total = asinh((r - 1)/width)/by_resonance - 1/(by_order*r)
   end function total

   !> Number of lines in a range.
   pure integer function needed(spacings, lines)
      !> Number of spacings of 17 lines in the range.
      real(wp), intent(in) :: spacings
      !> Least number of lines.
      integer, intent(in) :: lines

      needed = 1 + ceiling(min(spacings/16, real(most, wp))*(lines - 1)*(1 - 1.0e-9_wp))
      needed = max(lines, needed)
   end function needed

   !> Evenly spaced numbers from 0 to 1.
   pure function even(lines) result(at)
      !> Number of lines, at least 2.
      integer, intent(in) :: lines
      real(wp) :: at(lines)
      integer :: i

      at = [(i - 1, i=1, lines)]/real(lines - 1, wp)
   end function even

   !> The lines nearest to a point.
   pure function nearest_lines(lattice, q) result(place)
      !> The lattice.
      type(lattice_type), intent(in) :: lattice
      !> Coordinates of the point, in the units of the lines.
      real(wp), intent(in) :: q(2)
      integer :: place(2), i

      place = [(minloc(abs(lattice%axes(i)%at - q(i)), dim=1), i=1, 2)]
   end function nearest_lines

   !> The distance between the lines on both sides of a coordinate; of a single line, some share of
   !! the unit square.
   pure real(wp) function line_spacing(lattice, direction, q)
      !> The lattice.
      type(lattice_type), intent(in) :: lattice
      !> 1 for lines of constant r, 2 for lines of constant D.
      integer, intent(in) :: direction
      !> The coordinate, in the units of the lines.
      real(wp), intent(in) :: q
      real(wp), parameter :: single = 0.125_wp
      integer :: i

      line_spacing = single
      associate (at => lattice%axes(direction)%at)
         if (size(at) == 1) return
         i = count(at(2:size(at) - 1) <= q) + 1
         line_spacing = at(i + 1) - at(i)
      end associate
   end function line_spacing

end module vi_lattice
