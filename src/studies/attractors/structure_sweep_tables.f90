!> Sweeps of structures along a parameter: their keys, and their tables in a result.
module vi_structure_sweep_tables
   use vi_chains, only: chains_type, settle_chains
   use vi_common_keys, only: check_product, most_numbers, turn_upwards
   use vi_kinds, only: wp
   use vi_progress, only: is_stopped
   use vi_simulated_motion, only: cell_type, examination_type, simulated_motion_type
   use vi_simulated_structure, only: new_simulated_structure, simulated_structure_type
   use vi_spacing, only: even
   use vi_status, only: stat, status_text
   use vi_structure, only: load_type, structure_type
   use vi_structure_find, only: open_gaps
   use vi_structure_path, only: changed, structure_path_type, value_at
   use vi_structure_run, only: is_far, new_run, run_type, state_now
   use vi_structure_tables, only: set_unit
   use vi_study, only: a_whole, a_word, column_type, key_type, result_type, values_type, &
      wholes, words
   use vi_text, only: counted, whole
   implicit none (type, external)
   private

   public :: check_sweep, run_sweep, shares_of, value_count

   !> The keys of all sweeps of structures.
   type(key_type), parameter, public :: sweep_keys(*) = [ &
      key_type('values', a_whole, low=2.0_wp, high=1.0e6_wp, never='list', option='values', &
      meaning='number of values, evenly spaced'), &
      key_type('list', least=2, most=1000000, may_miss=.true., takes='two or more increasing &
      &or decreasing numbers in the range of the parameter', &
      meaning='values of the parameter, if they are not evenly spaced'), &
      key_type('sweep', a_word, default='''both''', words='up down both', &
      meaning='up, down, or up and then down; the state is carried from value to value')]

   !> The columns of what was found at each value.
   type(column_type), parameter, public :: cell_columns(*) = [ &
      column_type('cells', 'value', meaning='value of the parameter'), &
      column_type('cells', 'run', words, words='up,down', meaning='direction of the sweep'), &
      column_type('cells', 'cycles', wholes, &
      meaning='load cycles of the period; 0 if none is confirmed'), &
      column_type('cells', 'impacts', wholes, &
      meaning='impacts of a period, or without a period in all cycles examined; with stops or &
      &friction all events'), &
      column_type('cells', 'rests', wholes, meaning='rests, counted in the same way'), &
      column_type('cells', 'status', wholes, listed=.false., &
      meaning='code of the failure; 0: none')]

   !> A sweep of a structure.
   type, extends(chains_type) :: structure_chain_type
      !> The structure and its load as functions of the parameter.
      type(structure_path_type) :: path
      !> (links, chains) The parameter, as shares of the way between its bounds.
      real(wp), allocatable :: shares(:, :)
      !> (2n) Coordinates and velocities at the beginning, and after a failure; (outputs, n) outputs
      !! whose sizes are measured, as sums of the coordinates.
      real(wp), allocatable :: start(:), outputs(:, :)
   contains
      procedure :: go_to
   end type structure_chain_type

contains

   !> Number of values.
   pure integer function value_count(study) result(n)
      !> The group.
      type(values_type), intent(in) :: study

      if (study%has('list')) then
         n = size(study%numbers('list'))
      else
         n = study%whole_number('values')
      end if
   end function value_count

   !> The values, as shares of the way from the first to the last one.
   pure function shares_of(study) result(shares)
      !> The group.
      type(values_type), intent(in) :: study
      real(wp) :: shares(value_count(study))

      if (study%has('list')) then
         associate (list => study%numbers('list'), n => size(shares))
            shares = (list - list(1))/(list(n) - list(1))
         end associate
      else
         shares = even(0.0_wp, 1.0_wp, size(shares))
      end if
   end function shares_of

   !> Checks the values and their number.
   subroutine check_sweep(study, coordinates)
      !> The group.
      type(values_type), intent(inout) :: study
      !> Number of coordinates.
      integer, intent(in) :: coordinates

      call turn_upwards(study, 'list', [character(1) ::])
      if (study%has('list')) then
         associate (list => study%numbers('list'))
            if (any(list(2:) <= list(:size(list) - 1))) call study%refuse('list')
         end associate
      end if
      call check_product(study, trim(merge('list  ', 'values', study%has('list'))), &
         [2*value_count(study), study%whole_number('keep'), 2*coordinates], 'values x keep x &
         &coordinates must be at most '//whole(most_numbers)//' numbers')
   end subroutine check_sweep

   !> Sweeps over the values of a case, and fills the table of the cells, with notes.
   subroutine run_sweep(study, path, points, strobes, outputs, cells, order, &
      result, progress)
      !> The group.
      type(values_type), intent(in) :: study
      !> The structure and its load as functions of the parameter.
      type(structure_path_type), intent(in) :: path
      !> Impacts that are kept at each value.
      integer, intent(in) :: points
      !> Whether states are kept.
      logical, intent(in) :: strobes
      !> (outputs, n) Outputs whose sizes are measured, as sums of the coordinates.
      real(wp), intent(in) :: outputs(:, :)
      !> What was found, as far as it was reached, and the number of the value of each.
      type(cell_type), allocatable, intent(out) :: cells(:)
      integer, allocatable, intent(out) :: order(:)
      !> In and out: marked if it was stopped.
      type(result_type), intent(inout) :: result
      !> Progress counters, see vi_progress.
      integer, intent(inout), optional :: progress(3)
      type(structure_chain_type) :: sweep
      type(cell_type), allocatable :: all_cells(:)
      real(wp), allocatable :: shares(:)
      integer, allocatable :: runs(:)
      character(:), allocatable :: name
      integer :: done, first, i, last, lost, n

      n = value_count(study)
      first = merge(n + 1, 1, study%is('sweep', 'down'))
      last = merge(n, 2*n, study%is('sweep', 'up'))
      order = [(merge(i, 2*n + 1 - i, i <= n), i=first, last)]
      runs = [(merge(1, 2, i <= n), i=first, last)]
      allocate (shares, source=shares_of(study))
      sweep%links = size(order)
      sweep%path = path
      sweep%shares = reshape(shares(order), [size(order), 1])
      sweep%start = [study%numbers('q'), study%numbers('q_dot')]
      sweep%outputs = outputs
      sweep%sizes = [size(sweep%start)/2 + size(outputs, 1), size(sweep%start), 2]
      allocate (all_cells(size(order)))
      call settle_chains(sweep, examination_type(study%whole_number('settling'), &
         study%whole_number('keep'), points, study%whole_number('max_events'), strobes), 1, &
         all_cells, progress)
      done = count(all_cells%status /= stat%not_computed)
      if (is_stopped(progress) .and. done < size(all_cells)) result%cut = whole(done)//' of '// &
         counted(size(all_cells), 'value')//' were reached'
      allocate (cells, source=all_cells(:done))
      order = order(:done)
      name = 'frequency'
      if (study%has('parameter')) call study%text('parameter', name)
      if (study%has('label')) call study%text('label', name)
      call set_unit(result, 'cells', 'value', name)
      call result%open('cells', 'cell', [done])
      call result%put('cells', 'value', [(value_at(path%changes(1), shares(order(i))), i=1, done)])
      call result%put('cells', 'run', runs(:done))
      call result%put('cells', 'cycles', cells%cycles)
      call result%put('cells', 'impacts', cells%impacts)
      call result%put('cells', 'rests', cells%rests)
      call result%put('cells', 'status', cells%status)
      lost = count(cells%status /= stat%ok)
      result%empty = lost == done
      if (.not. result%empty) call result%add_note(counted(done, 'value')//', '// &
         whole(count(cells%cycles > 0))//' with a period')
      if (lost == 0) return
      i = findloc(cells%status /= stat%ok, .true., 1)
      call result%fail(whole(lost)//' of '//counted(done, 'value')//' failed: '// &
         status_text(cells(i)%status))
   end subroutine run_sweep

   !> Brings a simulation to a value; it goes on from the last state of the value before.
   subroutine go_to(chains, link, chain, motion, status)
      !> The sweep.
      class(structure_chain_type), intent(in) :: chains
      !> Numbers of the link and of the chain.
      integer, intent(in) :: link, chain
      !> In: the simulation at the value before, if there is one. Out: at this value.
      class(simulated_motion_type), allocatable, intent(inout) :: motion
      !> In: the status at the value before. Out: `stat%ok`, or why there is no simulation.
      integer, intent(inout) :: status
      type(structure_type) :: structure
      type(load_type) :: load
      type(run_type) :: run
      real(wp) :: here(size(chains%start))

      here = chains%start
      associate (n => size(here)/2)
         if (allocated(motion)) then
            select type (motion)
            type is (simulated_structure_type)
               ! again after a failure
               if (status == stat%ok) then
                  call state_now(motion%run, motion%state, here(:n), here(n + 1:))
                  ! a vibration that has decayed below the range of a simulation has ended
                  if (maxval(abs(here)) < 1 .and. is_far(motion%run, here(:n), here(n + 1:))) then
                     here = 0
                  end if
               end if
            end select
            deallocate (motion)
         end if
         call changed(chains%path, [chains%shares(link, chain)], structure, load)
         call new_run(structure, load, run, status)
         if (status /= stat%ok) return
         ! a start that is too far is refused, as in a simulation, not moved into the gaps
         if (is_far(run, here(:n), here(n + 1:))) status = stat%extreme_units
         if (status /= stat%ok) return
         call open_gaps(structure, here(:n))
         allocate (simulated_structure_type :: motion)
         select type (motion)
         type is (simulated_structure_type)
            call new_simulated_structure(run, 0.0_wp, here, 0, motion, status)
            motion%outputs = chains%outputs
         end select
      end associate
   end subroutine go_to

end module vi_structure_sweep_tables
