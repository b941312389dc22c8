!> Splits the text of a namelist into groups and assignments that remember their lines.
!!
!! Values are not interpreted here. A text that starts with `#` is a result of this program: only
!! the lines with a leading `#` are read, without the `#`, so that every result file is an input
!! that reproduces it. The time is proportional to the length of the text.
module vi_namelist
   use vi_text, only: lower, whole
   implicit none (type, external)
   private

   public :: scan_namelist

   !> `key = value` as written in the file.
   type, public :: assignment_type
      !> Name in lower case: `target` with its subscript, if it has one, and `key` without.
      character(:), allocatable :: target, key
      character(:), allocatable :: value
      integer :: line = 0
   end type assignment_type

   !> A group, `&name` to the closing slash.
   type, public :: group_type
      character(:), allocatable :: name
      integer :: line = 0
      type(assignment_type), allocatable :: items(:)
   end type group_type

   !> A position in a text, and its line.
   type :: place_type
      integer :: at = 1, line = 1
   end type place_type

   character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
   character(*), parameter :: name_characters = letters//'0123456789_%'
   character, parameter :: line_feed = achar(10), tab = achar(9)

contains

   !> All groups of a text in order; `message` and `line` describe the first syntax error.
   pure subroutine scan_namelist(source, groups, line, message)
      !> The text, its lines separated by line feeds.
      character(*), intent(in) :: source
      !> The groups.
      type(group_type), allocatable, intent(out) :: groups(:)
      !> Line of the fault; 0 if there is none.
      integer, intent(out) :: line
      !> Empty if there is no fault.
      character(:), allocatable, intent(out) :: message
      type(group_type) :: group
      type(place_type) :: begin
      character(:), allocatable :: text, plain
      integer :: at, first, last, n

      line = 0
      message = ''
      call clean(source, text)
      plain = text                             ! with comments and line ends replaced by blanks
      allocate (groups(1))
      n = 0
      at = 1
      do
         at = next_text(text, at)
         if (at > len(text)) exit
         call advance(text, at, begin)
         line = begin%line
         if (text(at:at) /= '&') then
            message = trim(text(at:line_end(text, at)))// &
               ': is outside a group; a group starts with & and ends with /'
            return
         end if
         last = verify(text(at + 1:), name_characters)
         if (last == 0) last = len(text) - at + 1
         group%name = lower(text(at + 1:at + last - 1))
         group%line = line
         first = at + last
         call close_group(text, plain, first, begin, last, at, line, message)
         if (len(message) > 0) then
            message = '&'//group%name//': '//message
            return
         end if
         call split_body(plain, text, first, last, begin, group, line, message)
         if (len(message) > 0) return
         call keep(group, n, groups)
      end do
      line = 0
      groups = groups(:n)
      if (n == 0) message = 'contains no namelist group; a case starts with &system'
   end subroutine scan_namelist

   !> Replaces tabs by blanks. If the text starts with #, keeps only the lines that do, without the
   !! #; the others become empty.
   pure subroutine clean(source, text)
      !> The text, its lines separated by line feeds.
      character(*), intent(in) :: source
      !> The text to be read, with the same number of lines.
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: copied
      logical :: is_result, starts, kept
      integer :: i, n

      allocate (character(len(source)) :: copied)
      is_result = index(source, '#') == 1
      starts = .true.
      kept = .true.
      n = 0
      do i = 1, len(source)
         if (starts) kept = .not. is_result .or. source(i:i) == '#'
         if (source(i:i) == line_feed .or. (kept .and. .not. (starts .and. is_result))) then
            n = n + 1
            copied(n:n) = merge(' ', source(i:i), source(i:i) == tab)
         end if
         starts = source(i:i) == line_feed
      end do
      text = copied(:n)
   end subroutine clean

   !> Position of the first character at or after `from` that is neither blank nor part of a comment
   !! outside a group; after the end of the text if there is none.
   pure integer function next_text(text, from) result(at)
      !> The text.
      character(*), intent(in) :: text
      !> A position; may be after the end of the text.
      integer, intent(in) :: from

      at = from
      do while (at <= len(text))
         if (text(at:at) == '!') then
            at = line_end(text, at) + 1
         else if (text(at:at) == ' ' .or. text(at:at) == line_feed) then
            at = at + 1
         else
            return
         end if
      end do
   end function next_text

   !> Position of the last character of a line.
   pure integer function line_end(text, from) result(last)
      !> The text.
      character(*), intent(in) :: text
      !> A position in the line.
      integer, intent(in) :: from

      last = index(text(from:), line_feed)
      last = merge(from + last - 2, len(text), last > 0)
   end function line_end

   !> Moves a place forward to a later position.
   pure subroutine advance(text, at, place)
      !> The text.
      character(*), intent(in) :: text
      !> The position; nothing is done if the place is already there or beyond.
      integer, intent(in) :: at
      !> In and out.
      type(place_type), intent(inout) :: place
      integer :: i

      do i = place%at, at - 1
         if (text(i:i) == line_feed) place%line = place%line + 1
      end do
      place%at = max(place%at, at)
   end subroutine advance

   !> Finds the closing slash of a group, and replaces comments and line ends before it by blanks.
   pure subroutine close_group(text, plain, first, begin, last, at, line, message)
      !> The text.
      character(*), intent(in) :: text
      !> In: the text. Out: with blanks in place of comments and line ends of the group.
      character(:), allocatable, intent(inout) :: plain
      !> Position after `&name`.
      integer, intent(in) :: first
      !> The place of `&name`.
      type(place_type), intent(in) :: begin
      !> Position of the last character before the slash.
      integer, intent(out) :: last
      !> Position after the slash.
      integer, intent(out) :: at
      !> Out: line of the fault; not changed if it is that of `&name`.
      integer, intent(inout) :: line
      !> The fault; empty if there is none.
      character(:), allocatable, intent(out) :: message
      type(place_type) :: here
      character :: quote
      integer :: start, comment

      message = ''
      quote = ' '
      here = begin
      start = first                                     ! of the line, or of the text after `&name`
      last = first - 1
      at = first
      do while (at <= len(text))
         if (text(at:at) == line_feed) then
            if (quote /= ' ') exit
            plain(at:at) = ' '
            start = at + 1
         else if (quote /= ' ') then
            if (text(at:at) == quote) quote = ' '
         else if (text(at:at) == '''' .or. text(at:at) == '"') then
            quote = text(at:at)
         else if (text(at:at) == '!') then
            comment = at
            at = line_end(text, at)
            plain(comment:at) = ' '
         else if (text(at:at) == '/') then
            last = at - 1
            at = at + 1
            return
         else if (text(at:at) == '&') then
            if (lower(text(at:min(len(text), at + 3))) == '&end') then
               last = at - 1
               at = at + 4
            else
               call advance(text, at, here)
               message = 'no / closes the group of line '//whole(begin%line)//' before '// &
                  trim(text(at:line_end(text, at)))//' in line '//whole(here%line)
            end if
            return
         end if
         at = at + 1
      end do
      if (quote /= ' ') then
         call advance(text, start, here)
         line = here%line
         message = trim(adjustl(text(start:line_end(text, start))))//': the quote is not closed'
      else
         message = 'no / closes the group of line '//whole(begin%line)
      end if
   end subroutine close_group

   !> Moves a group into a growing list.
   pure subroutine keep(group, n, groups)
      !> In: the group. Out: without its texts.
      type(group_type), intent(inout) :: group
      !> In and out: number of groups in the list.
      integer, intent(inout) :: n
      !> In and out: the list, with unused entries at its end.
      type(group_type), allocatable, intent(inout) :: groups(:)
      type(group_type), allocatable :: longer(:)
      integer :: i

      if (n == size(groups)) then
         allocate (longer(2*n))
         do i = 1, n
            call move(groups(i), longer(i))
         end do
         call move_alloc(longer, groups)
      end if
      n = n + 1
      call move(group, groups(n))
   end subroutine keep

   !> Moves a group without copying its texts.
   pure subroutine move(from, to)
      !> In: the group. Out: without its texts.
      type(group_type), intent(inout) :: from
      !> The group.
      type(group_type), intent(out) :: to

      to%line = from%line
      call move_alloc(from%name, to%name)
      call move_alloc(from%items, to%items)
   end subroutine move

   !> Removes the blanks from a text.
   pure subroutine squeeze(text)
      !> In and out.
      character(:), allocatable, intent(inout) :: text
      integer :: i, n

      n = 0
      do i = 1, len(text)
         if (text(i:i) == ' ') cycle
         n = n + 1
         text(n:n) = text(i:i)
      end do
      text = text(:n)
   end subroutine squeeze

   !> Reduces each run of blanks outside quotes to one blank, and removes those at the ends.
   pure subroutine tidy(text)
      !> In and out.
      character(:), allocatable, intent(inout) :: text
      character :: quote, before
      integer :: i, n

      n = 0
      quote = ' '
      before = ' '
      do i = 1, len(text)
         if (quote /= ' ') then
            if (text(i:i) == quote) quote = ' '
         else if (text(i:i) == '''' .or. text(i:i) == '"') then
            quote = text(i:i)
         else if (text(i:i) == ' ' .and. before == ' ') then
            cycle
         end if
         n = n + 1
         before = text(i:i)
         text(n:n) = before
      end do
      text = trim(text(:n))
   end subroutine tidy

   !> Splits the text of a group into `target = value` at its equals signs.
   pure subroutine split_body(plain, text, first, last, begin, group, line, message)
      !> The text, with blanks in place of comments and line ends of the group.
      character(*), intent(in) :: plain
      !> The text.
      character(*), intent(in) :: text
      !> Positions of the first and the last character of the group after `&name`.
      integer, intent(in) :: first, last
      !> In: the place of `&name`. Out: a later place.
      type(place_type), intent(inout) :: begin
      !> In: with its name. Out: with its assignments.
      type(group_type), intent(inout) :: group
      !> Out: line of the fault, or of the last assignment if there is none.
      integer, intent(inout) :: line
      !> The fault; empty if there is none.
      character(:), allocatable, intent(out) :: message
      type(assignment_type) :: item
      type(assignment_type), allocatable :: kept(:)
      integer :: equals, next, start, next_start, i, n

      message = ''
      allocate (group%items(count([(plain(i:i) == '=', i=first, last)])))
      n = 0
      equals = next_equals(plain(:last), first)
      start = last + 1
      if (equals > 0) start = target_start(plain(:equals - 1), first)
      i = first - 1 + verify(plain(first:start - 1), ' ')
      if (i >= first) then
         call advance(text, i, begin)
         line = begin%line
         item%value = plain(i:start - 1)
         call tidy(item%value)
         message = '&'//group%name//' '//item%value//': must be of the form key = value'
         return
      end if
      do while (equals > 0)
         next = next_equals(plain(:last), equals + 1)
         next_start = last + 1
         if (next > 0) next_start = target_start(plain(:next - 1), equals + 1)
         item%target = lower(plain(start:equals - 1))
         call squeeze(item%target)
         call advance(text, merge(equals, start, len(item%target) == 0), begin)
         line = begin%line
         item%line = line
         item%key = item%target
         if (index(item%key, '(') > 0) item%key = trim(item%key(:index(item%key, '(') - 1))
         item%value = plain(equals + 1:max(equals, next_start - 1))
         call tidy(item%value)
         i = len(item%value)                       ! the comma before the next key
         if (i > 0) then
            if (item%value(i:i) == ',') item%value = trim(item%value(:i - 1))
         end if
         if (len(item%key) == 0 .or. next_start <= equals) then
            message = '&'//group%name//' '//item%target//' = '//item%value// &
               ': must be of the form key = value'
            return
         end if
         n = n + 1
         group%items(n)%line = item%line
         call move_alloc(item%target, group%items(n)%target)
         call move_alloc(item%key, group%items(n)%key)
         call move_alloc(item%value, group%items(n)%value)
         start = next_start
         equals = next
      end do
      if (n == size(group%items)) return
      ! an equals sign stood in a text
      allocate (kept(n))
      do i = 1, n
         kept(i) = group%items(i)
      end do
      call move_alloc(kept, group%items)
   end subroutine split_body

   !> The next equals sign outside quotes at or after `from`, or 0.
   pure integer function next_equals(text, from) result(position)
      !> The text.
      character(*), intent(in) :: text
      !> Position at which the search starts; outside quotes.
      integer, intent(in) :: from
      character :: quote

      quote = ' '
      do position = from, len(text)
         if (quote /= ' ') then
            if (text(position:position) == quote) quote = ' '
         else if (text(position:position) == '''' .or. text(position:position) == '"') then
            quote = text(position:position)
         else if (text(position:position) == '=') then
            return
         end if
      end do
      position = 0
   end function next_equals

   !> Position at which the name (with its subscript) at the end of a text starts.
   pure integer function target_start(text, from) result(start)
      !> The text before an equals sign.
      character(*), intent(in) :: text
      !> Position at which the name starts at the earliest.
      integer, intent(in) :: from
      integer :: last

      last = from - 1 + len_trim(text(from:))
      if (text(last:last) == ')') then
         last = from - 1 + len_trim(text(from:from - 2 + index(text(from:last), '(', back=.true.)))
      end if
      start = from + verify(text(from:last), name_characters, back=.true.)
   end function target_start

end module vi_namelist
