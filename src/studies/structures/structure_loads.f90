!> The group &load of a structure: harmonics, constant forces, records of forces, and motions of a
!! base by harmonics or by samples.
module vi_structure_loads
   use vi_case, only: case_type
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_matrix_file, only: beside, read_samples
   use vi_structure, only: load_type
   use vi_structure_matrices, only: matrices_of, most_coordinates, most_numbers
   use vi_text, only: brief, counted, number_text, whole
   use vi_values, only: values_type
   implicit none (type, external)
   private

   public :: check_load, complete_coordinates, complete_record, load_frequency, load_of, &
      record_end, record_of

   !> Largest number of harmonics, and of harmonics times coordinates.
   integer, parameter :: most_harmonics = 100, most_amplitudes = most_harmonics*most_coordinates
   !> Largest number of numbers of a record.
   integer, parameter :: most_samples = 10**7

   type(key_type), parameter, public :: load_keys(*) = [ &
      key_type('frequency', low=0.0_wp, above=.true., may_miss=.true., &
      meaning='circular frequency Omega of the load'), &
      key_type('cosine', most=most_amplitudes, may_miss=.true., only='frequency', &
      takes='one number for each coordinate, harmonic by harmonic', &
      meaning='amplitudes of cos(Omega t), then of cos(2 Omega t), ...; 0 if it is left out'), &
      key_type('sine', most=most_amplitudes, may_miss=.true., only='frequency', &
      takes='one number for each coordinate, harmonic by harmonic', &
      meaning='amplitudes of sin(Omega t), then of sin(2 Omega t), ...; 0 if it is left out'), &
      key_type('constant', most=most_coordinates, may_miss=.true., &
      takes='one number for each coordinate', meaning='constant forces, such as gravity'), &
      key_type('record', most=most_samples, may_miss=.true., or='record_file', &
      never='frequency', takes='one number for each column, sample by sample, with at least two &
      &samples', meaning='samples of forces or, with base, of the motion of the base; they start &
      &at time 0, are interpolated linearly, and are followed by 0'), &
      key_type('record_file', a_word, may_miss=.true., or='record', never='frequency', &
      takes='a CSV file, a Matrix Market file (real, general) or a NumPy file (.npy, float64), &
      &with a row for each sample, at least two, and at most 1e7 numbers', &
      meaning='file with the samples; a relative path starts from the folder of the namelist'), &
      key_type('step', low=0.0_wp, above=.true., may_miss=.true., &
      meaning='time between samples; not needed for a CSV file whose first column is named time'), &
      key_type('acts_on', a_whole, most=most_coordinates, low=0.0_wp, &
      high=most_coordinates - 1.0_wp, may_miss=.true., never='base weights', &
      takes='the number of a coordinate, from 0, for each column, no number twice', &
      meaning='coordinates on which the columns act; all of them if it is left out'), &
      key_type('weights', most=most_numbers, may_miss=.true., never='base', &
      takes='one number for each coordinate, column by column', &
      meaning='forces on the coordinates for a value of 1 in each column'), &
      key_type('base', a_word, may_miss=.true., words='acceleration motion', &
      takes='''acceleration'' (one column) or ''motion'' (two columns)', &
      meaning='the load is the acceleration of the base (for relative coordinates) or its &
      &displacement, in a record with its velocity (for absolute coordinates)'), &
      key_type('base_cosine', most=most_harmonics, may_miss=.true., low=-1.0e40_wp, &
      high=1.0e40_wp, only='base', never='record record_file', &
      takes='one number from -1e40 to 1e40 for each harmonic', &
      meaning='amplitudes of cos(Omega t), then of cos(2 Omega t), ... of the base; its forces &
      &are added to cosine, sine and constant'), &
      key_type('base_sine', most=most_harmonics, may_miss=.true., low=-1.0e40_wp, &
      high=1.0e40_wp, only='base', never='record record_file', &
      takes='one number from -1e40 to 1e40 for each harmonic', &
      meaning='amplitudes of sin(Omega t), then of sin(2 Omega t), ... of the base'), &
      key_type('base_direction', most=most_coordinates, may_miss=.true., only='base', &
      takes='one number for each coordinate', meaning='displacements of the coordinates when the &
      &base moves by 1 and nothing deforms; 1 if it is left out')]

contains

   !> Checks a load.
   pure subroutine check_load(load, coordinates)
      !> The group.
      type(values_type), intent(inout) :: load
      !> Number of coordinates.
      integer, intent(in) :: coordinates
      character(8), parameter :: names(3) = [character(8) :: 'cosine', 'sine', 'constant'], &
         of_record(3) = [character(8) :: 'step', 'acts_on', 'weights']
      logical :: good
      integer :: i, length

      do i = 1, size(names)
         if (.not. load%has(trim(names(i)))) cycle
         length = size(load%numbers(trim(names(i))))
         good = modulo(length, coordinates) == 0
         if (i == 3) good = length == coordinates
         if (.not. good) call load%refuse(trim(names(i)), 'it has '// &
            counted(length, 'number')//' for '//counted(coordinates, 'coordinate'))
      end do
      if (load%has('record') .or. load%has('record_file')) return
      if (moves_base(load)) then
         if (.not. load%has('frequency')) call load%refuse('frequency')
      else if (load%has('base')) then
         call load%forbid('base', ': it requires record, record_file, base_cosine or base_sine')
      else if (.not. any([(load%has(trim(names(i))), i=1, 3)])) then
         call load%refuse('constant', 'or give cosine or sine')
      end if
      do i = 1, size(of_record)
         call load%forbid(trim(of_record(i)), ': it requires record or record_file')
      end do
   end subroutine check_load

   !> Whether harmonics of the base are given.
   pure logical function moves_base(load)
      !> The group.
      type(values_type), intent(in) :: load

      moves_base = load%has('base_cosine') .or. load%has('base_sine')
   end function moves_base

   !> Reads the file of a record, checks the record, and replaces the motion of a base by its
   !! weights, or by harmonics of forces.
   subroutine complete_record(path, structure, n, load)
      !> The file of the namelist; empty if there is none.
      character(*), intent(in) :: path
      !> &structure, complete.
      type(values_type), intent(in) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      character(:), allocatable :: given, of_columns
      integer :: columns, in_file

      if (len(load%fault) > 0) return
      if (moves_base(load)) call add_base(structure, n, load)
      if (.not. (load%has('record') .or. load%has('record_file'))) return
      call count_columns(load, n, columns, of_columns)
      in_file = 0
      given = 'record'
      if (load%has('record_file')) then
         given = 'record_file'
         if (len(load%fault) == 0) call read_record_file(path, load, in_file)
      end if
      if (len(load%fault) > 0) return
      if (in_file > 0 .and. in_file /= columns) then
         call load%refuse(given, 'it has '//counted(in_file, 'column')//', not the '// &
            whole(columns)//of_columns)
      else if (modulo(size(load%numbers('record')), columns) /= 0) then
         call load%refuse(given, 'it has '//counted(size(load%numbers('record')), 'number')// &
            ' for the '//counted(columns, 'column')//of_columns)
      else if (size(load%numbers('record')) < 2*columns) then
         call load%refuse(given, 'it has one sample')
      else if (.not. load%has('step')) then
         call load%refuse('step')
      else if (load%has('base')) then
         call set_base(structure, n, load)
      end if
      call load%drop('record_file')
   end subroutine complete_record

   !> The number of columns of a record, by the keys next to it, which are checked.
   subroutine count_columns(load, n, columns, why)
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      !> Number of coordinates.
      integer, intent(in) :: n
      !> Number of columns.
      integer, intent(out) :: columns
      !> Where the number comes from, as the end of a message.
      character(:), allocatable, intent(out) :: why
      integer, allocatable :: numbers(:)
      integer :: i

      columns = n
      why = ' of all coordinates; or give acts_on, weights or base'
      if (load%has('base')) then
         columns = merge(1, 2, load%is('base', 'acceleration'))
         why = ' of base'
         if (load%has('base_direction')) call complete_coordinates(load, 'base_direction', n)
      else if (load%has('weights')) then
         columns = size(load%numbers('weights'))/n
         why = ' of weights'
         if (modulo(size(load%numbers('weights')), n) /= 0) call load%refuse('weights', &
            'it has '//counted(size(load%numbers('weights')), 'number')//' for '// &
            counted(n, 'coordinate'))
      else if (load%has('acts_on')) then
         numbers = load%whole_numbers('acts_on')
         columns = size(numbers)
         why = ' of acts_on'
         if (any(numbers >= n) .or. any([(count(numbers == numbers(i)) > 1, i=1, columns)])) then
            call load%refuse('acts_on', 'the structure has '//counted(n, 'coordinate'))
         end if
      end if
   end subroutine count_columns

   !> Reads the samples of a file, and their step if the file has times.
   subroutine read_record_file(path, load, columns)
      !> The file of the namelist; empty if there is none.
      character(*), intent(in) :: path
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      !> Number of columns in the file.
      integer, intent(out) :: columns
      !> Share of the step by which a time may differ, as where few digits are written.
      real(wp), parameter :: share = 0.05_wp
      real(wp), allocatable :: numbers(:), times(:)
      character(:), allocatable :: file, full, message
      real(wp) :: step
      integer :: i, last

      call load%text('record_file', file)
      call beside(path, file, full)
      call read_samples(full, most_coordinates, most_samples, numbers, columns, times, message)
      last = size(times) - 1
      if (len(message) == 0 .and. last > 0) then
         step = times(last + 1)/last
         if (load%has('step')) step = load%number('step')
         if (.not. step > 0) message = 'its times must ascend from 0'
         i = findloc([(abs(times(i + 1) - i*step) <= share*step, i=0, last)], .false., 1)
         if (len(message) == 0 .and. i > 0) message = 'sample '//whole(i)//' is at time '// &
            trim(number_text(times(i), .false.))//'; must be '//trim(number_text((i - 1)*step, &
            .false.))//', as the samples start at 0 with the step '// &
            trim(number_text(step, .false.))
         if (.not. load%has('step')) call load%set('step', [step])
      end if
      if (len(message) > 0) then
         call load%refuse('record_file', full//': '//brief(message))
      else
         call load%set('record', numbers)
      end if
   end subroutine read_record_file

   !> Replaces the motion of a base by the forces for 1 in each column.
   subroutine set_base(structure, n, load)
      !> &structure, complete.
      type(values_type), intent(in) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      real(wp) :: forces(n, 2)

      call forces_of_base(structure, n, load, forces)
      call load%set('weights', [forces(:, :merge(1, 2, load%is('base', 'acceleration')))])
      call load%drop('base')
      call load%drop('base_direction')
   end subroutine set_base

   !> Adds the forces of a base that moves by harmonics to those of &load: K d y + C d y' of its
   !! displacement y, where y' has the sine amplitude -h Omega c and the cosine amplitude h Omega s,
   !! or -M d a of its acceleration a.
   subroutine add_base(structure, n, load)
      !> &structure, complete.
      type(values_type), intent(in) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      real(wp) :: forces(n, 2)
      real(wp), allocatable :: base(:, :), cosine(:, :), sine(:, :)
      integer :: h, harmonics, own

      if (load%has('base_direction')) call complete_coordinates(load, 'base_direction', n)
      if (len(load%fault) > 0) return
      call forces_of_base(structure, n, load, forces)
      own = max(amplitudes(load, 'base_cosine'), amplitudes(load, 'base_sine'))
      harmonics = max(own, amplitudes(load, 'cosine')/n, amplitudes(load, 'sine')/n)
      allocate (base(2, own), cosine(n, harmonics), sine(n, harmonics), source=0.0_wp)
      if (load%has('base_cosine')) base(:1, :) = padded(load%numbers('base_cosine'), 1, own)
      if (load%has('base_sine')) base(2:, :) = padded(load%numbers('base_sine'), 1, own)
      if (load%has('cosine')) cosine = padded(load%numbers('cosine'), n, harmonics)
      if (load%has('sine')) sine = padded(load%numbers('sine'), n, harmonics)
      associate (omega => load%number('frequency'))
         do h = 1, own
            cosine(:, h) = cosine(:, h) + forces(:, 1)*base(1, h) &
               + forces(:, 2)*(h*omega*base(2, h))
            sine(:, h) = sine(:, h) + forces(:, 1)*base(2, h) &
               - forces(:, 2)*(h*omega*base(1, h))
         end do
      end associate
      call load%set('cosine', [cosine])
      call load%set('sine', [sine])
      call load%drop('base')
      call load%drop('base_cosine')
      call load%drop('base_sine')
      call load%drop('base_direction')
   end subroutine add_base

   !> Number of amplitudes of a key, 0 if it is not given.
   pure integer function amplitudes(load, name)
      !> The group.
      type(values_type), intent(in) :: load
      !> The key.
      character(*), intent(in) :: name

      amplitudes = 0
      if (load%has(name)) amplitudes = size(load%numbers(name))
   end function amplitudes

   !> The forces for 1 of the motion of a base: -M d and 0 for its acceleration, K d and C d for its
   !! displacement and velocity.
   subroutine forces_of_base(structure, n, load, forces)
      !> &structure, complete.
      type(values_type), intent(in) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      !> The forces.
      real(wp), intent(out) :: forces(n, 2)
      real(wp) :: matrices(n, n, 3)
      real(wp), allocatable :: d(:)
      integer :: i

      if (.not. load%has('base_direction')) then
         if (structure%has('frequencies')) call load%refuse('base_direction', &
            'it is required if the coordinates are modal amplitudes')
         call load%set('base_direction', spread(1.0_wp, 1, n))
      end if
      allocate (d, source=load%numbers('base_direction'))
      call matrices_of(structure, n, matrices)
      forces = 0
      ! coordinate by coordinate, so that the digits do not depend on a library
      do i = 1, n
         if (load%is('base', 'acceleration')) then
            forces(:, 1) = forces(:, 1) - d(i)*matrices(:, i, 1)
         else
            forces(:, 1) = forces(:, 1) + d(i)*matrices(:, i, 3)
            forces(:, 2) = forces(:, 2) + d(i)*matrices(:, i, 2)
         end if
      end do
   end subroutine forces_of_base

   !> Checks the length of a list of numbers, one for each coordinate; zeros if there is none.
   subroutine complete_coordinates(study, name, coordinates)
      !> The group.
      type(values_type), intent(inout) :: study
      !> The key.
      character(*), intent(in) :: name
      !> Number of coordinates.
      integer, intent(in) :: coordinates

      if (.not. study%has(name)) call study%set(name, spread(0.0_wp, 1, coordinates))
      if (size(study%numbers(name)) /= coordinates) call study%refuse(name, &
         'it has '//counted(size(study%numbers(name)), 'number')//' for '// &
         counted(coordinates, 'coordinate'))
   end subroutine complete_coordinates

   !> The load of a case; a gap as its last group has none of the keys of a load.
   pure subroutine load_of(case, load)
      !> A case with a structure.
      type(case_type), intent(in) :: case
      !> The load; without harmonics its frequency is 0.
      type(load_type), intent(out) :: load
      real(wp), allocatable :: samples(:, :), weights(:, :)
      integer :: harmonics, i, j

      associate (n => case%coordinates, group => case%parts(size(case%parts)))
         harmonics = 0
         allocate (load%constant(n), source=0.0_wp)
         if (group%has('cosine')) harmonics = size(group%numbers('cosine'))/n
         if (group%has('sine')) harmonics = max(harmonics, size(group%numbers('sine'))/n)
         if (harmonics > 0) load%frequency = group%number('frequency')
         if (group%has('constant')) load%constant = group%numbers('constant')
         allocate (load%cosine(n, harmonics), load%sine(n, harmonics), source=0.0_wp)
         if (group%has('cosine')) load%cosine = padded(group%numbers('cosine'), n, harmonics)
         if (group%has('sine')) load%sine = padded(group%numbers('sine'), n, harmonics)
         if (.not. group%has('record')) return
         load%step = group%number('step')
         call record_of(case, samples, weights)
         allocate (load%record(n, size(samples, 2)), source=0.0_wp)
         do j = 1, size(weights, 2)
            do i = 1, n
               if (abs(weights(i, j)) > 0) load%record(i, :) = load%record(i, :) &
                  + weights(i, j)*samples(j, :)
            end do
         end do
      end associate
   end subroutine load_of

   !> Amplitudes with zeros for further harmonics.
   pure function padded(numbers, n, harmonics) result(array)
      !> Harmonic by harmonic.
      real(wp), intent(in) :: numbers(:)
      !> Numbers of coordinates and of harmonics.
      integer, intent(in) :: n, harmonics
      real(wp) :: array(n, harmonics)

      array = reshape(numbers, [n, harmonics], pad=[0.0_wp])
   end function padded

   !> The record of a case: its columns, and the forces for 1 in each.
   pure subroutine record_of(case, samples, weights)
      !> A case with a structure.
      type(case_type), intent(in) :: case
      !> (columns, samples) The samples; without columns if there is no record.
      real(wp), allocatable, intent(out) :: samples(:, :)
      !> (coordinates, columns) The forces.
      real(wp), allocatable, intent(out) :: weights(:, :)
      integer, allocatable :: on(:)
      integer :: columns, i

      associate (load => case%parts(size(case%parts)), n => case%coordinates)
         columns = 0
         if (load%has('record')) then
            on = [(i, i=0, n - 1)]
            if (load%has('acts_on')) on = load%whole_numbers('acts_on')
            columns = size(on)
            if (load%has('weights')) columns = size(load%numbers('weights'))/n
         end if
         allocate (weights(n, columns), source=0.0_wp)
         if (columns == 0) then
            allocate (samples(0, 0))
            return
         end if
         samples = reshape(load%numbers('record'), [columns, size(load%numbers('record'))/columns])
         if (load%has('weights')) then
            weights = reshape(load%numbers('weights'), [n, columns])
         else
            do i = 1, columns
               weights(on(i) + 1, i) = 1
            end do
         end if
      end associate
   end subroutine record_of

   !> Time of the last sample of the record of a case; negative if it has none.
   pure real(wp) function record_end(case) result(time)
      !> A case with a structure.
      type(case_type), intent(in) :: case
      real(wp), allocatable :: samples(:, :), weights(:, :)

      time = -1
      call record_of(case, samples, weights)
      if (size(samples) > 0) time = case%parts(size(case%parts))%number('step')*(size(samples, 2) &
         - 1)
   end function record_end

   !> Circular frequency of the load of a case; 0 if it has none.
   pure real(wp) function load_frequency(case) result(frequency)
      !> The case.
      type(case_type), intent(in) :: case

      frequency = 0
      associate (last => case%parts(size(case%parts)))
         if (last%has('frequency')) frequency = last%number('frequency')
      end associate
   end function load_frequency

end module vi_structure_loads
