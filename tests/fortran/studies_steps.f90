!> Zeros of a condition between two points of a curve: on parabolas they are known.
module studies_steps
   use checks, only: check
   use random_numbers, only: draw, fill, random_type
   use vi_crossing, only: hidden_zero, may_dip
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   public :: test_steps

   type(random_type) :: random

contains

   subroutine test_steps()
      call test_parabolas()
      call test_straight_lines()
   end subroutine test_steps

   !> A parabola through three points on one side of zero is assumed to cross it where, and only
   !! where, its extremum lies between them on the other side; with a margin, near zero, too.
   subroutine test_parabolas()
      real(wp) :: first, second, extreme, at, bend, value(3), margin
      logical :: inside
      integer :: i, hidden, near

      hidden = 0
      near = 0
      do i = 1, 20000
         first = draw(random, 0.01_wp, 1.0_wp)
         second = draw(random, 0.01_wp, 1.0_wp)
         at = draw(random, -1.5_wp, 1.5_wp)
         extreme = draw(random, -0.5_wp, 0.5_wp)
         bend = draw(random, -4.0_wp, 4.0_wp)
         value = extreme + bend*([-first, 0.0_wp, second] - at)**2
         ! cases that rounding could decide
         if (abs(extreme) < 1.0e-9_wp .or. abs(at + first) < 1.0e-9_wp .or. &
            abs(at - second) < 1.0e-9_wp .or. abs(bend) < 1.0e-3_wp) cycle
         inside = at > -first .and. at < second .and. value(1)*value(2) > 0 .and. &
            value(2)*value(3) > 0
         call check(hidden_zero(value(1), value(2), value(3), first, second) .eqv. &
            inside .and. extreme*value(2) < 0, 'zeros of a parabola')
         ! a search of both steps misses none
         if (inside .and. extreme*value(2) < 0) call check(may_dip(value(1), value(2), value(3), &
            first, second) .or. may_dip(value(3), value(2), value(1), second, first) .or. &
            abs(value(2)) > min(abs(value(1)), abs(value(3))), 'a search finds both zeros')
         margin = draw(random, 0.01_wp, 0.9_wp)
         if (abs(extreme - margin*value(2)) < 1.0e-9_wp) cycle
         call check(hidden_zero(value(1), value(2), value(3), first, second, margin) .eqv. &
            inside .and. extreme*value(2) < margin*value(2)**2, 'near zero')
         if (inside .and. extreme*value(2) < 0) hidden = hidden + 1
         if (inside .and. extreme*value(2) > 0) near = near + 1
      end do
      call check(hidden > 500 .and. near > 100, 'steps: both cases occur')
   end subroutine test_parabolas

   !> A straight line, a step of zero length, and a change of sign hide nothing.
   subroutine test_straight_lines()
      real(wp) :: value(3)
      integer :: i

      do i = 1, 200
         call fill(random, 0.1_wp, 2.0_wp, value)
         call check(.not. hidden_zero(value(1), value(1), value(1), value(2), value(3), 0.5_wp), &
            'a constant')
         call check(.not. may_dip(value(1), value(1), value(1), value(2), value(3)), 'no dip')
         call check(.not. may_dip(2.0_wp, 1.5_wp, 1.0_wp, 1.0_wp, 1.0_wp), 'a falling line')
         call check(.not. hidden_zero(1.0_wp, 1.5_wp, 2.0_wp, 1.0_wp, 1.0_wp, 0.99_wp), 'a line')
         call check(.not. hidden_zero(value(1), -value(2), value(3), 1.0_wp, 1.0_wp, 0.5_wp), &
            'two changes of sign')
         call check(.not. hidden_zero(value(1), 0.0_wp, value(3), 1.0_wp, 1.0_wp, 0.5_wp), 'a zero')
         call check(.not. hidden_zero(1.0_wp, 0.1_wp, 1.0_wp, 0.0_wp, value(3), 0.5_wp), &
            'no first step')
         call check(.not. hidden_zero(1.0_wp, 0.1_wp, 1.0_wp, value(3), 0.0_wp, 0.5_wp), &
            'no second step')
      end do
   end subroutine test_straight_lines

end module studies_steps
