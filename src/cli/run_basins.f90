!> Runs a case with basins of attraction: one row a state.
module vi_run_basins
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use vi_attractor_catalogue, only: catalogue_type, label_states
   use vi_attractor_known, only: ball, known_type, no_impacts, periodic, repeating, resting
   use vi_attractor_integrity, only: largest_disc, uncertain_pairs, uncertainty_exponent
   use vi_basins_study, only: initial_states
   use vi_case, only: case_type, echo
   use vi_drive, only: new_drive
   use vi_kinds, only: wp
   use vi_log, only: done, failed, log_type, say, write_table
   use vi_pattern, only: starred_letters
   use vi_processor, only: available_threads
   use vi_text, only: append, columns, counted, exact, exact_list, lengthen, line_type, shown, whole
   use vi_window, only: even
   implicit none (type, external)
   private

   public :: run_basins

   character(14), parameter :: kinds(6) = [character(14) :: 'periodic', 'rest', 'quasi-periodic', &
      'chaotic', 'no impacts', 'periodic?']

contains

   !> Finds to which attractor each state goes, and writes the states.
   subroutine run_basins(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(catalogue_type) :: catalogue
      type(line_type), allocatable :: names(:), lines(:)
      real(wp), allocatable :: states(:, :)
      integer, allocatable :: labels(:)
      character(:), allocatable :: text
      real(wp) :: events
      integer :: i, lost

      written = .true.
      associate (s => case%study)
         catalogue%drive = new_drive(case%osc, case%r, s%number('load'), s%number('clearance'))
         catalogue%max_cycles = s%whole_number('max_cycles')
         catalogue%threads = available_threads()
         allocate (states, source=initial_states(case))
         allocate (labels(size(states, 2)))
         call label_states(catalogue, states, s%whole_number('cycles'), s%whole_number('probes'), &
            labels, events, tally)
      end associate
      lost = count(labels <= 0)
      if (lost < size(labels)) then
         call find_names(catalogue, names)
         call basin_lines(case, catalogue, names, states, labels, lines)
         call write_table(folder//'/'//case%name//'.csv', lines, log, written)
         if (.not. written) return
         text = counted(size(labels), 'state')
         do i = 1, catalogue%n
            text = text//', '//names(i)%text//' '//shown(100*share(labels, i), 'f12.2')//'% +- '// &
               shown(100*standard_error(labels, i), 'f12.2')//'%'
         end do
         call say(log, done, case%name//': '//text)
      end if
      if (lost > 0) call say(log, failed, case%name//': '//whole(lost)//' of '//counted( &
         size(labels), 'state')//' not decided')
   end subroutine run_basins

   !> The states with the numbers of their attractors; header as in `csv_lines`, with those.
   pure subroutine basin_lines(case, catalogue, names, states, labels, lines)
      type(case_type), intent(in) :: case
      type(catalogue_type), intent(in) :: catalogue
      type(line_type), intent(in) :: names(:)
      real(wp), intent(in) :: states(:, :)
      integer, intent(in) :: labels(:)
      type(line_type), allocatable, intent(out) :: lines(:)
      character(:), allocatable :: text
      integer :: i, j, n

      call echo(case, lines)
      do i = 1, catalogue%n
         text = '# ! '//whole(i - 1)//': '//names(i)%text//' ('//trim(kinds( &
            catalogue%known(i)%kind))//'), share '//exact(share(labels, i))
         call add_details(catalogue%known(i), text)
         call append(lines, text)
      end do
      call append_safety(case, catalogue%n, labels, lines)
      call append(lines, 't,x,x_dot,z,z_dot,label,attractor')
      n = size(lines)
      call lengthen(lines, size(labels))
      do j = 1, size(labels)
         text = columns(states(:, j))
         text = text(2:)//','//whole(labels(j) - 1)//','
         if (labels(j) > 0) text = text//names(labels(j))%text
         lines(n + j)%text = text
      end do
   end subroutine basin_lines

   !> Share of the states that go to an attractor.
   pure real(wp) function share(labels, i)
      integer, intent(in) :: labels(:), i

      share = real(count(labels == i), wp)/size(labels)
   end function share

   !> Of the share, as of as many independent states: an upper bound for those of a plane.
   pure real(wp) function standard_error(labels, i)
      integer, intent(in) :: labels(:), i

      standard_error = sqrt(share(labels, i)*(1 - share(labels, i))/size(labels))
   end function standard_error

   !> How sure the shares are, and of a plane how safe its states.
   pure subroutine append_safety(case, n, labels, lines)
      type(case_type), intent(in) :: case
      !> Attractors.
      integer, intent(in) :: n, labels(:)
      type(line_type), allocatable, intent(inout) :: lines(:)
      integer, allocatable :: plane(:, :)
      character(:), allocatable :: text
      real(wp) :: exponent
      integer :: sizes(2), i

      if (case%study%has('values')) then
         sizes = case%study%whole_numbers('values')
         plane = reshape(labels, [sizes(2), sizes(1)])
      end if
      do i = 1, n
         text = '# ! '//whole(i - 1)//': standard error of the share '//exact(standard_error( &
            labels, i))
         if (allocated(plane)) call add_disc(case, plane, i, text)
         call append(lines, text)
      end do
      if (.not. allocated(plane)) return
      exponent = uncertainty_exponent(uncertain_pairs(plane))
      if (.not. ieee_is_nan(exponent)) call append(lines, '# ! uncertainty exponent '//exact( &
         exponent))
   end subroutine append_safety

   !> Adds the largest disc of the plane inside a basin.
   pure subroutine add_disc(case, plane, i, text)
      type(case_type), intent(in) :: case
      !> (second axis, first axis)
      integer, intent(in) :: plane(:, :), i
      character(:), allocatable, intent(inout) :: text
      real(wp) :: low(2), high(2), cells(2), radius, first(size(plane, 2)), second(size(plane, 1))
      integer :: place(2), n(2)

      low = case%study%numbers('low')
      high = case%study%numbers('high')
      n = case%study%whole_numbers('values')
      first = even(low(1), high(1), n(1))
      second = even(low(2), high(2), n(2))
      cells = (high(2:1:-1) - low(2:1:-1))/(n(2:1:-1) - 1)
      call largest_disc(plane, i, cells, radius, place)
      text = text//', radius of the largest disc '//exact(radius)//' about '// &
         trim(case%study%word('axes', 1))//', '//trim(case%study%word('axes', 2))//' = '// &
         exact(first(place(2)))//', '//exact(second(place(1)))
   end subroutine add_disc

   !> Adds what else is known of an attractor.
   pure subroutine add_details(known, text)
      type(known_type), intent(in) :: known
      character(:), allocatable, intent(inout) :: text
      real(wp) :: numbers(2)

      select case (known%kind)
      case (periodic, resting)
         numbers = ball(known)
         text = text//', greatest multiplier '//exact(known%largest)//', radius '// &
            exact(numbers(1))
      case (no_impacts, repeating)
      case default
         text = text//', largest exponent per load cycle '//exact(known%largest)
      end select
      text = text//'; t, x, x_dot, z, z_dot = '//exact_list(known%state)
   end subroutine add_details

   !> Sides and load cycles, or the kind; a number tells those of one name apart.
   pure subroutine find_names(catalogue, names)
      type(catalogue_type), intent(in) :: catalogue
      type(line_type), allocatable, intent(out) :: names(:)
      type(line_type) :: plain(catalogue%n)
      integer :: i, j, before, alike

      allocate (names(catalogue%n))
      do i = 1, catalogue%n
         associate (known => catalogue%known(i))
            select case (known%kind)
            case (periodic, resting)
               plain(i)%text = starred_letters(known%letters)//'/'//whole(known%cycles)
            case (repeating)
               plain(i)%text = whole(size(known%letters))//'/'//whole(known%cycles)//'?'
            case default
               plain(i)%text = trim(kinds(known%kind))
            end select
         end associate
      end do
      do i = 1, catalogue%n
         before = 0
         alike = 0
         do j = 1, catalogue%n
            if (plain(j)%text /= plain(i)%text) cycle
            alike = alike + 1
            if (j <= i) before = before + 1
         end do
         names(i)%text = plain(i)%text
         if (alike > 1) names(i)%text = names(i)%text//' ('//whole(before)//')'
      end do
   end subroutine find_names

end module vi_run_basins
