!> Splits the text of a namelist into groups and assignments that remember their lines.
!!
!! Values are not interpreted here. A text that starts with `#` is a result of this program: only
!! the lines with a leading `#` are read, without it, so that every table is an input that
!! reproduces it.
module vi_namelist
   use vi_text, only: detab, line_type, lower, whole
   implicit none (type, external)
   private

   public :: scan_namelist

   !> `key = value` as it stands in the file.
   type, public :: assignment_type
      !> Lower case, with its subscript if it has one, and without.
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

   !> Text of one group with the line of each character.
   type :: body_type
      character(:), allocatable :: text
      integer, allocatable :: line(:)
   end type body_type

   character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
   character(*), parameter :: name_characters = letters//'0123456789_%'
   character(*), parameter :: blanks = ' '//achar(9)

contains

   !> All groups of a text in order; `message` and `line` describe the first fault of its form.
   pure subroutine scan_namelist(text, groups, line, message)
      !> The lines.
      type(line_type), intent(in) :: text(:)
      !> The groups.
      type(group_type), allocatable, intent(out) :: groups(:)
      !> Line of the fault, 0 if it has none.
      integer, intent(out) :: line
      !> Empty if there is no fault.
      character(:), allocatable, intent(out) :: message
      type(line_type), allocatable :: lines(:)
      type(group_type) :: group
      type(body_type) :: body
      character(:), allocatable :: rest
      integer :: i, j, n

      line = 0
      message = ''
      lines = text
      call strip_hash(lines)
      n = 0                                             ! groups so far; room for all that can come
      do i = 1, size(lines)
         n = n + count([(lines(i)%text(j:j) == '&', j=1, len(lines(i)%text))])
      end do
      allocate (groups(n))
      n = 0
      i = 1
      rest = ''
      if (size(lines) > 0) rest = lines(1)%text
      do
         rest = adjustl(detab(rest))
         if (len_trim(rest) == 0 .or. index(rest, '!') == 1) then
            i = i + 1
            if (i > size(lines)) exit
            rest = lines(i)%text
            cycle
         end if
         line = i
         if (rest(1:1) /= '&') then
            message = trim(rest)//': stands outside a group; a group starts with & and ends with /'
            return
         end if
         call open_group(rest, group)
         group%line = i
         call collect_body(lines, i, rest, body, line, message)
         if (len(message) > 0) then
            message = '&'//group%name//': '//message
            return
         end if
         call split_body(body, group, line, message)
         if (len(message) > 0) return
         n = n + 1
         groups(n) = group
      end do
      line = 0
      groups = groups(:n)
      if (n == 0) message = 'holds no namelist group; a case starts with &system'
   end subroutine scan_namelist

   !> If the first line starts with #, keeps only the lines that do, without the #.
   pure subroutine strip_hash(lines)
      !> In and out: the lines; those without # become empty.
      type(line_type), intent(inout) :: lines(:)
      integer :: i

      if (size(lines) == 0) return
      if (index(lines(1)%text, '#') /= 1) return
      do i = 1, size(lines)
         if (index(lines(i)%text, '#') == 1) then
            lines(i)%text = lines(i)%text(2:)
         else
            lines(i)%text = ''
         end if
      end do
   end subroutine strip_hash

   !> Reads `&name` at the start of a text.
   pure subroutine open_group(rest, group)
      !> In: starts with `&name`. Out: the text after it.
      character(:), allocatable, intent(inout) :: rest
      !> Out: with its name.
      type(group_type), intent(out) :: group
      integer :: last

      last = verify(rest(2:), name_characters)
      if (last == 0) last = len(rest)
      group%name = lower(rest(2:last))
      rest = rest(last + 1:)
   end subroutine open_group

   !> Collects the text of a group up to its closing slash, without comments.
   !!
   !! On entry `rest` is the text after `&name` on line i; on return it is the text after the slash
   !! on the new line i.
   pure subroutine collect_body(lines, i, rest, body, line, message)
      !> All lines.
      type(line_type), intent(in) :: lines(:)
      !> In: number of the line of `&name`. Out: that of the closing slash.
      integer, intent(inout) :: i
      !> In: text of the line after `&name`. Out: text of the line after the slash.
      character(:), allocatable, intent(inout) :: rest
      !> The text of the group, with the line number of each character.
      type(body_type), intent(out) :: body
      !> Line of the fault.
      integer, intent(inout) :: line
      !> The fault; empty if there is none.
      character(:), allocatable, intent(out) :: message
      character :: quote
      integer :: j, first

      message = ''
      body%text = ''
      allocate (body%line(0))
      first = i
      do
         quote = ' '
         j = 1
         do while (j <= len(rest))
            if (quote /= ' ') then
               if (rest(j:j) == quote) quote = ' '
            else if (rest(j:j) == '''' .or. rest(j:j) == '"') then
               quote = rest(j:j)
            else if (rest(j:j) == '!') then
               exit
            else if (rest(j:j) == '/' .or. lower(rest(j:min(len(rest), j + 3))) == '&end') then
               call extend(body, rest(:j - 1), i)
               rest = rest(j + merge(1, 4, rest(j:j) == '/'):)
               return
            else if (rest(j:j) == '&') then
               message = 'no / closes the group of line '//whole(first)//' before ' &
                  //trim(rest(j:)) &
                  //' in line '//whole(i)
               return
            end if
            j = j + 1
         end do
         if (quote /= ' ') then
            line = i
            message = trim(adjustl(rest))//': the quote is not closed'
            return
         end if
         call extend(body, rest(:j - 1)//' ', i)
         i = i + 1
         if (i > size(lines)) then
            message = 'no / closes the group of line '//whole(first)
            return
         end if
         rest = lines(i)%text
      end do
   end subroutine collect_body

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

   !> Appends a text to the body of a group.
   pure subroutine extend(body, text, line)
      !> In and out: the body.
      type(body_type), intent(inout) :: body
      !> What is appended; tabs become blanks.
      character(*), intent(in) :: text
      !> Number of its line.
      integer, intent(in) :: line
      integer :: i

      body%text = body%text//detab(text)
      body%line = [body%line, [(line, i=1, len(text))]]
   end subroutine extend

   !> Splits the text of a group into `target = value` at its equals signs.
   pure subroutine split_body(body, group, line, message)
      !> The text of the group.
      type(body_type), intent(in) :: body
      !> In: with its name. Out: with its assignments.
      type(group_type), intent(inout) :: group
      !> Out: line of the fault; otherwise of the last assignment.
      integer, intent(inout) :: line
      !> The fault; empty if there is none.
      character(:), allocatable, intent(out) :: message
      type(assignment_type) :: item
      integer :: equals, next, start, next_start, i, n

      message = ''
      n = 0
      allocate (group%items(count([(body%text(i:i) == '=', i=1, len(body%text))])))
      equals = next_equals(body%text, 1)
      start = 1
      if (equals > 0) start = target_start(body%text, equals)
      if (equals == 0) start = len(body%text) + 1
      if (len_trim(body%text(:start - 1)) > 0) then
         i = verify(body%text, blanks)
         line = body%line(i)
         message = '&'//group%name//' '//trim(adjustl(body%text(:start - 1)))// &
            ': must be of the form key = value'
         return
      end if
      do while (equals > 0)
         next = next_equals(body%text, equals + 1)
         next_start = len(body%text) + 1
         if (next > 0) next_start = target_start(body%text, next)
         line = body%line(min(start, size(body%line)))
         item%line = line
         item%target = lower(body%text(start:equals - 1))
         call squeeze(item%target)
         if (len(item%target) == 0) line = body%line(equals)
         item%key = item%target
         if (index(item%key, '(') > 0) item%key = trim(item%key(:index(item%key, '(') - 1))
         item%value = trim(adjustl(body%text(equals + 1:max(equals, next_start - 1))))
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
         group%items(n) = item
         start = next_start
         equals = next
      end do
      group%items = group%items(:n)
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

   !> Position at which the name (with its subscript) before an equals sign starts.
   pure integer function target_start(text, equals) result(start)
      !> The text.
      character(*), intent(in) :: text
      !> Position of the equals sign.
      integer, intent(in) :: equals
      integer :: last

      last = len_trim(text(:equals - 1))
      start = last + 1
      if (last == 0) return
      if (text(last:last) == ')') then
         last = index(text(:last), '(', back=.true.) - 1
         last = len_trim(text(:max(0, last)))
      end if
      start = verify(text(:last), name_characters, back=.true.) + 1
   end function target_start

end module vi_namelist
