!> Values of a namelist: conversion of numbers and words as written in the file.
!!
!! The compiler's own namelist input accepts text that is certainly a mistake (`1+2`, half a list, a
!! list that ends with the name of a variable). Here only the documented forms are accepted.
module vi_parse
   use vi_kinds, only: wp
   use vi_text, only: line_type
   implicit none (type, external)
   private

   public :: parse_numbers, parse_subscript, parse_words, repeats

   character(*), parameter :: digits = '0123456789'

contains

   !> Numbers with commas or blanks between them, and repeats such as 2*0.75.
   pure subroutine parse_numbers(text, whole, most, values, good)
      !> The text as written in the file.
      character(*), intent(in) :: text
      !> Whether whole numbers are wanted.
      logical, intent(in) :: whole
      !> Largest number of values.
      integer, intent(in) :: most
      !> The numbers; those that were read before the fault, if there is one.
      real(wp), allocatable, intent(out) :: values(:)
      !> False if the text contains anything else, or too many values.
      logical, intent(out) :: good
      real(wp), allocatable :: buffer(:)
      real(wp) :: value, times
      integer :: i, n, first, last, star
      logical :: wants_value

      allocate (buffer(int(min(real(most, wp), len(text)/2 + 1 + repeats(text)))))
      n = 0
      i = 1
      good = .true.
      wants_value = .true.
      do while (good)
         i = next_text(text, i)
         if (i > len(text)) exit
         if (text(i:i) == ',') then
            good = .not. wants_value
            wants_value = .true.
            i = i + 1
            cycle
         end if
         first = i
         last = scan(text(first:), ' ,')
         last = merge(first + last - 2, len(text), last > 0)
         i = last + 1
         star = index(text(first:last), '*')
         times = 1
         if (star > 0) call parse_number(text(first:first + star - 2), .true., times, good)
         if (good) call parse_number(text(first + star:last), whole, value, good)
         good = good .and. times >= 1 .and. n + times <= most
         if (.not. good) exit
         buffer(n + 1:n + int(times)) = value
         n = n + int(times)
         wants_value = .false.
      end do
      good = good .and. n > 0 .and. .not. wants_value
      values = buffer(:n)
   end subroutine parse_numbers

   !> How many values the repeats of a text stand for, such as 2 in 2*0.75.
   pure real(wp) function repeats(text)
      !> The text as written in the file.
      character(*), intent(in) :: text
      real(wp) :: times
      integer :: star, first, next
      logical :: good

      repeats = 0
      star = 0
      do
         next = index(text(star + 1:), '*')
         if (next == 0) exit
         star = star + next
         first = verify(text(:star - 1), digits, back=.true.) + 1
         call parse_number(text(first:star - 1), .true., times, good)
         ! a star within a word is no repeat
         if (good .and. first > 1) good = scan(text(first - 1:first - 1), ' ,') > 0
         if (good) repeats = repeats + times
      end do
   end function repeats

   !> One number: sign, digits, point, exponent.
   pure subroutine parse_number(text, whole, value, good)
      !> Without blanks.
      character(*), intent(in) :: text
      !> Whether only digits and a sign are allowed.
      logical, intent(in) :: whole
      !> The number, rounded to nearest.
      real(wp), intent(out) :: value
      !> Whether the text is a number, below 1e308, and not rounded to 0.
      logical, intent(out) :: good
      integer :: i, j, n_digits, status, first, point, power

      value = 0
      i = 1
      if (len(text) > 0) i = 1 + merge(1, 0, scan(text(1:1), '+-') > 0)
      j = skip(text, i)
      n_digits = j - i
      point = j
      i = j
      if (.not. whole .and. i <= len(text)) then
         if (text(i:i) == '.') then
            j = skip(text, i + 1)
            n_digits = n_digits + j - i - 1
            i = j
         end if
      end if
      good = n_digits > 0
      power = 0
      if (good .and. .not. whole .and. i <= len(text)) then
         good = scan(text(i:i), 'eEdD') > 0
         i = i + 1
         if (i <= len(text)) i = i + merge(1, 0, scan(text(i:i), '+-') > 0)
         j = skip(text, i)
         good = good .and. j > i .and. j - i < 7
         if (good) read (text(scan(text, 'eEdD') + 1:j - 1), '(i7)') power
         i = j
      end if
      good = good .and. i > len(text) .and. len(text) <= 400
      if (.not. good) return
      ! the place of the first significant digit gives the magnitude, so that reading cannot
      ! overflow
      first = scan(text, '123456789')
      if (scan(text(:max(0, first)), 'eEdD') > 0) first = 0
      if (first == 0) then
         if (text(1:1) == '-') value = -value
         return
      end if
      good = power + point - first - merge(1, 0, first < point) < 308
      if (.not. good) return
      read (text, '(f400.0)', iostat=status) value
      ! a number that has become 0 is not what was written
      good = status == 0 .and. abs(value) > 0
   end subroutine parse_number

   !> Position of the first character at or after `from` that is not blank; after the end of the
   !! text if there is none.
   pure integer function next_text(text, from) result(i)
      !> A text.
      character(*), intent(in) :: text
      !> A position; may be after the end of the text.
      integer, intent(in) :: from

      i = verify(text(from:), ' ')
      i = merge(from + i - 1, len(text) + 1, i > 0)
   end function next_text

   !> The position after the digits that start at a given position.
   pure integer function skip(text, from) result(i)
      !> A text.
      character(*), intent(in) :: text
      !> Position at which to start; may be after the end.
      integer, intent(in) :: from

      i = from
      do while (i <= len(text))
         if (scan(text(i:i), digits) == 0) exit
         i = i + 1
      end do
   end function skip

   !> Words in quotes, with commas or blanks between them; a doubled quote stands for a single one.
   pure subroutine parse_words(text, most, words, good)
      !> The text as written in the file.
      character(*), intent(in) :: text
      !> Largest number of words.
      integer, intent(in) :: most
      !> The words, without trailing blanks.
      type(line_type), allocatable, intent(out) :: words(:)
      !> False if the text contains anything else, or too many values.
      logical, intent(out) :: good
      character(len(text)) :: word
      type(line_type) :: found(most)
      character :: quote
      integer :: i, n, length
      logical :: wants_value

      n = 0
      i = 1
      good = .true.
      wants_value = .true.
      do while (good)
         i = next_text(text, i)
         if (i > len(text)) exit
         quote = text(i:i)
         i = i + 1
         if (quote == ',') then
            good = .not. wants_value
            wants_value = .true.
            cycle
         end if
         good = scan(quote, '''"') > 0 .and. n < most
         if (.not. good) exit
         length = 0
         do
            good = i <= len(text)
            if (.not. good) exit
            if (text(i:i) == quote) then
               if (text(i:min(len(text), i + 1)) /= quote//quote) exit
               i = i + 1
            end if
            length = length + 1
            word(length:length) = text(i:i)
            i = i + 1
         end do
         i = i + 1
         n = n + 1
         found(n)%text = trim(word(:length))
         wants_value = .false.
      end do
      good = good .and. n > 0 .and. .not. wants_value
      allocate (words(n))
      do i = 1, n
         words(i)%text = found(i)%text
      end do
   end subroutine parse_words

   !> The part of a list to which a subscript refers: (2) is one place, (2:5) and (2:) are several.
   pure subroutine parse_subscript(text, most, first, last, good)
      !> The text after the name of the key, without blanks; empty for the whole list.
      character(*), intent(in) :: text
      !> Largest number of values in the list.
      integer, intent(in) :: most
      !> First and last place.
      integer, intent(out) :: first, last
      !> False if this is not a subscript, or if it is outside the list.
      logical, intent(out) :: good
      real(wp) :: low, high
      integer :: colon

      first = 1
      last = most
      good = .true.
      if (len(text) == 0) return
      good = most > 1 .and. len(text) > 2
      if (.not. good) return
      associate (inside => text(2:len(text) - 1))
         colon = index(inside, ':')
         low = 1
         high = most
         if (colon == 0) then
            call parse_number(inside, .true., low, good)
            ! as in any namelist, further values go to the places after it
         else
            if (colon > 1) call parse_number(inside(:colon - 1), .true., low, good)
            if (good .and. colon < len(inside)) call parse_number(inside(colon + 1:), .true., &
               high, good)
         end if
         good = good .and. text(len(text):) == ')' .and. low >= 1 .and. low <= high .and. high <= &
            most
         if (.not. good) return
         first = nint(low)
         last = nint(high)
      end associate
   end subroutine parse_subscript

end module vi_parse
