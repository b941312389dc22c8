!> Branches as CSV: one row a point.
module vi_report_branch
   use vi_branch, only: end_bound, end_closed, end_full, end_repetition, &
      end_stopped
   use vi_branch_of, only: points_type
   use vi_case, only: case_type, echo
   use vi_condition_names, only: condition_detail, condition_name, name_length
   use vi_kinds, only: wp
   use vi_report, only: verdict_word
   use vi_text, only: append, columns, line_type, whole
   implicit none (type, external)
   private

   public :: branch_lines, end_text, special_name

contains

   !> The points of all branches of a case, in order along each; header as in `csv_lines`.
   pure subroutine branch_lines(case, branches, lines)
      type(case_type), intent(in) :: case
      type(points_type), intent(in) :: branches(:)
      type(line_type), allocatable, intent(out) :: lines(:)
      type(line_type), allocatable :: head(:)
      character(:), allocatable :: header, text
      integer :: i, j, k, n, impacts

      call echo(case, head)
      do i = 1, size(branches)
         call append(head, '# ! branch '//whole(i)//': first end: '// &
            end_text(branches(i)%reasons(1))//'; last end: '//end_text(branches(i)%reasons(2)))
      end do
      header = 'branch,point,r,clearance,xi,mu,R1,R2,consistent,admissible,stable,'// &
         'multiplier_1_modulus,multiplier_2_modulus,multiplier_3_modulus,multiplier_4_modulus,'// &
         'A,tau,residual,x_min,x_max,attenuation'
      impacts = size(branches(1)%phases, 1)
      do j = 1, impacts
         header = header//',phase_'//whole(j)
      end do
      do j = 1, impacts
         header = header//',X_'//whole(j)
      end do
      call append(head, header//',special,detail')
      n = size(head)
      allocate (lines(n + sum(branches%n)))
      do i = 1, n
         call move_alloc(head(i)%text, lines(i)%text)
      end do
      do i = 1, size(branches)
         do k = 1, branches(i)%n
            n = n + 1
            text = whole(i)//','//whole(k)
            call add_point(branches(i), k, text)
            call move_alloc(text, lines(n)%text)
         end do
      end do
   end subroutine branch_lines

   !> Adds the columns of one point.
   pure subroutine add_point(branch, k, text)
      type(points_type), intent(in) :: branch
      integer, intent(in) :: k
      character(:), allocatable, intent(inout) :: text
      integer :: i

      text = text//columns(branch%parameters(:, k))
      do i = 1, 3
         text = text//','//verdict_word(branch%verdicts(i, k))
      end do
      associate (s => branch%scalars(:, k), special => branch%special(:, k))
         text = text//columns(abs(branch%multipliers(:, k)))//columns(s(2:))// &
            columns([max(-s(5), s(6))/s(2)])//columns(branch%phases(:, k))// &
            columns(branch%impacts(:, 1, k))//','//trim(special_name(branch, k))//','// &
            trim(condition_detail(special(1), special(2), special(3)))
      end associate
   end subroutine add_point

   !> The type of a special point; blank for another point.
   pure function special_name(branch, k) result(name)
      type(points_type), intent(in) :: branch
      integer, intent(in) :: k
      character(name_length) :: name

      name = ''
      if (branch%special(1, k) > 0) name = condition_name(branch%special(1, k), &
         branch%special(2, k), branch%symmetric, branch%mirrored)
   end function special_name

   !> Why a branch ends.
   pure function end_text(reason) result(text)
      integer, intent(in) :: reason
      character(len_trim(padded_end(reason))) :: text

      text = padded_end(reason)
   end function end_text

   !> The same with blanks behind it.
   pure function padded_end(reason) result(text)
      integer, intent(in) :: reason
      character(40) :: text

      select case (reason)
      case (end_bound)
         text = 'bound of the parameter'
      case (end_repetition)
         text = 'meets a motion that repeats itself'
      case (end_closed)
         text = 'closed'
      case (end_full)
         text = 'full'
      case (end_stopped)
         text = 'stopped'
      case default
         text = 'cannot be followed'
      end select
   end function padded_end

end module vi_report_branch
