!> Runs a case with Lyapunov exponents: one row a point.
module vi_run_lyapunov
   use vi_attractor_lyapunov, only: lyapunov_points
   use vi_case, only: case_type, echo
   use vi_drive, only: initial_state, new_drive, two_pi
   use vi_kinds, only: wp
   use vi_log, only: done, failed, log_type, say, write_table
   use vi_lyapunov_study, only: line_points
   use vi_common_keys, only: state_of
   use vi_processor, only: available_threads
   use vi_status, only: stat, status_text
   use vi_text, only: append, columns, counted, lengthen, line_type, whole
   use vi_trajectory, only: pack_state
   implicit none (type, external)
   private

   public :: run_lyapunov

   !> What is known of each point.
   type :: spectra_type
      real(wp), allocatable :: r(:), clearance(:), exponents(:, :), deviations(:, :), &
         dimensions(:), errors(:)
      integer, allocatable :: counts(:, :), status(:)
   end type spectra_type

contains

   !> Computes the exponents along a line of points, or at one, and writes them.
   subroutine run_lyapunov(case, folder, log, written, tally)
      type(case_type), intent(in) :: case
      character(*), intent(in) :: folder
      type(log_type), intent(inout) :: log
      !> False if the result could not be written.
      logical, intent(out) :: written
      !> As of vi_tally.
      integer, intent(inout), optional :: tally(3)
      type(spectra_type) :: found
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: reason
      integer :: j, lost

      written = .true.
      call compute(case, found, tally)
      lost = count(found%status /= stat%ok)
      if (lost < size(found%r)) then
         call spectra_lines(case, found, lines)
         call write_table(folder//'/'//case%name//'.csv', lines, log, written)
         if (.not. written) return
         call say(log, done, case%name//': '//counted(size(found%r), 'point')//', '//whole(count( &
            found%exponents(1, :) > 3*found%deviations(1, :)))//' with a positive exponent')
      end if
      if (lost == 0) return
      j = findloc(found%status /= stat%ok, .true., 1)
      if (found%status(j) == stat%no_motion) then
         reason = 'no impacts in a batch'
      else
         reason = status_text(found%status(j))
      end if
      call say(log, failed, case%name//': no exponents at '//whole(lost)//' of '//counted( &
         size(found%r), 'point')//': '//reason)
   end subroutine run_lyapunov

   subroutine compute(case, found, tally)
      type(case_type), intent(in) :: case
      type(spectra_type), intent(out) :: found
      integer, intent(inout), optional :: tally(3)
      real(wp), allocatable :: states(:, :), loads(:)
      integer, allocatable :: contacts(:, :)
      integer :: j, n, batches

      call line_points(case, found%r, found%clearance)
      n = size(found%r)
      allocate (states(7, n), contacts(3, n), loads(n), found%exponents(4, n), &
         found%deviations(4, n), found%dimensions(n), found%errors(n), found%counts(2, n), &
         found%status(n))
      associate (s => case%study)
         loads = s%number('load')
         batches = s%whole_number('batches')
         do j = 1, n
            call pack_state(initial_state(new_drive(case%osc, found%r(j), loads(j), &
               found%clearance(j)), state_of(s)), states(:, j), contacts(:, j))
         end do
         call lyapunov_points(case%osc, found%r, loads, found%clearance, states, contacts, &
            s%whole_number('discard'), s%whole_number('cycles')/batches, batches, &
            available_threads(), found%exponents, &
            found%deviations, found%dimensions, found%counts, found%errors, found%status, &
            tally)
      end associate
   end subroutine compute

   !> The exponents of each point, per load cycle; header as in `csv_lines`.
   pure subroutine spectra_lines(case, found, lines)
      type(case_type), intent(in) :: case
      type(spectra_type), intent(in) :: found
      type(line_type), allocatable, intent(out) :: lines(:)
      character(:), allocatable :: text
      integer :: j, n

      call echo(case, lines)
      call append(lines, 'r,clearance,exponent_1,exponent_2,exponent_3,exponent_4,error_1,'// &
         'error_2,error_3,error_4,dimension,identity_error,impacts,rests')
      n = size(lines)
      call lengthen(lines, size(found%r))
      do j = 1, size(found%r)
         associate (cycle_time => two_pi/found%r(j))
            text = columns([found%r(j), found%clearance(j), found%exponents(:, j)*cycle_time, &
               found%deviations(:, j)*cycle_time, found%dimensions(j), found%errors(j)])
         end associate
         lines(n + j)%text = text(2:)//','//whole(found%counts(1, j))//','// &
            whole(found%counts(2, j))
      end do
   end subroutine spectra_lines

end module vi_run_lyapunov
