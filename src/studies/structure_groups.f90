!> The groups of a structure: &structure, its gaps and its load.
module vi_structure_groups
   use vi_case, only: case_type
   use vi_eigen_routines, only: dsygv
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   use vi_matrix_file, only: beside, read_matrix, read_samples
   use vi_namelist, only: group_type
   use vi_restitution, only: constant_law, power_law, table_law
   use vi_structure, only: load_type, new_structure, structure_type
   use vi_text, only: brief, counted, number_text, whole
   use vi_values, only: read_values, values_type
   implicit none (type, external)
   private

   public :: complete_coordinates, load_frequency, read_parts, read_structure, record_end, &
      record_of, structure_of

   !> Largest number of coordinates of a structure, and of gaps.
   integer, parameter, public :: most_coordinates = 500
   integer, parameter :: most_numbers = most_coordinates**2
   !> Largest number of harmonics times coordinates.
   integer, parameter :: most_amplitudes = 100*most_coordinates
   !> Largest number of numbers of a record.
   integer, parameter :: most_samples = 10**7

   character(*), parameter :: matrix_takes = 'n numbers (the diagonal) or n*n numbers (a symmetric &
      &matrix, row by row), with n at most 500'
   character(*), parameter :: file_takes = 'a Matrix Market file (real, general or symmetric) or a &
      &NumPy file (.npy, float64), with a symmetric matrix of at most 500 rows or its diagonal'

   type(key_type), parameter, public :: structure_keys(*) = [ &
      key_type('mass', most=most_numbers, takes=matrix_takes, or='mass_file', never='frequencies', &
      meaning='mass matrix M of M q'''' + C q'' + K q = f, positive definite'), &
      key_type('damping', most=most_numbers, takes=matrix_takes, may_miss=.true., &
      or='damping_file', never='frequencies', &
      meaning='damping matrix C, without negative eigenvalues; 0 if it is left out'), &
      key_type('stiffness', most=most_numbers, takes=matrix_takes, may_miss=.true., &
      or='stiffness_file', never='frequencies', &
      meaning='stiffness matrix K, without negative eigenvalues; 0 if it is left out'), &
      key_type('mass_file', a_word, takes=file_takes, may_miss=.true., or='mass', &
      never='frequencies', meaning='file with M; its path starts at the folder of the namelist'), &
      key_type('damping_file', a_word, takes=file_takes, may_miss=.true., or='damping', &
      never='frequencies', meaning='file with C'), &
      key_type('stiffness_file', a_word, takes=file_takes, may_miss=.true., or='stiffness', &
      never='frequencies', meaning='file with K'), &
      key_type('frequencies', most=most_coordinates, low=0.0_wp, may_miss=.true., &
      takes='one number >= 0 for each mode, at most 500', &
      meaning='circular frequencies of modes, in place of matrices; the coordinates are their &
      &amplitudes'), &
      key_type('damping_ratios', most=most_coordinates, low=0.0_wp, only='frequencies', &
      takes='one number >= 0 for each mode', meaning='damping ratio of each mode'), &
      key_type('shapes', most=most_numbers, only='frequencies', &
      takes='one number for each mode, point by point', &
      meaning='mass-normalised shapes of the modes at the points to which gaps refer')]

   type(key_type), parameter, public :: gap_keys(*) = [ &
      key_type('direction', most=most_coordinates, &
      takes='one number for each coordinate (with modes for each point), not all 0', &
      meaning='the gap closes in this direction: opening - direction.q >= 0'), &
      key_type('opening', meaning='opening of the gap at q = 0; negative if it is closed there'), &
      key_type('restitution', low=0.0_wp, high=1.0_wp, default='1', never='law=table', &
      meaning='coefficient of restitution; with law = ''power'' that at low approach speeds'), &
      key_type('law', a_word, default='''constant''', words='constant power table', &
      meaning='how the coefficient of restitution depends on the approach speed'), &
      key_type('law_speed', low=0.0_wp, above=.true., only='law=power', &
      meaning='approach speed v0 of R (1 + (v/v0)^k)^(-p/k)'), &
      key_type('law_exponent', low=0.0_wp, only='law=power', &
      meaning='p, the exponent at high approach speeds'), &
      key_type('law_sharpness', low=0.0_wp, above=.true., default='2', only='law=power', &
      meaning='k, the sharpness of the corner at v0'), &
      key_type('law_speeds', most=most_coordinates, least=2, low=0.0_wp, only='law=table', &
      takes='at least two ascending numbers >= 0', meaning='approach speeds of a table'), &
      key_type('law_values', most=most_coordinates, least=2, low=0.0_wp, high=1.0_wp, &
      only='law=table', takes='one number from 0 to 1 for each of law_speeds', &
      meaning='coefficients of restitution at these speeds')]

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
      &samples', meaning='samples of forces, or with base of its motion: linear between them, from &
      &time 0 on, and 0 after the last one'), &
      key_type('record_file', a_word, may_miss=.true., or='record', never='frequency', &
      takes='a CSV file, a Matrix Market file (real, general) or a NumPy file (.npy, float64), &
      &with a row for each sample, at least two, and at most 1e7 numbers', &
      meaning='file with the samples; its path starts at the folder of the namelist'), &
      key_type('step', low=0.0_wp, above=.true., may_miss=.true., &
      meaning='time between samples; a CSV file whose first column is named time needs none'), &
      key_type('acts_on', a_whole, most=most_coordinates, low=0.0_wp, &
      high=most_coordinates - 1.0_wp, may_miss=.true., never='base weights', &
      takes='the number of a coordinate, from 0, for each column, no number twice', &
      meaning='coordinates on which the columns act; all of them if it is left out'), &
      key_type('weights', most=most_numbers, may_miss=.true., never='base', &
      takes='one number for each coordinate, column by column', &
      meaning='forces on the coordinates for 1 in each column'), &
      key_type('base', a_word, may_miss=.true., words='acceleration motion', &
      takes='''acceleration'' (one column) or ''motion'' (two columns)', &
      meaning='the columns are the acceleration of the base, and coordinates relative to it, or &
      &its displacement and velocity, and coordinates absolute'), &
      key_type('base_direction', most=most_coordinates, may_miss=.true., only='base', &
      takes='one number for each coordinate', meaning='displacements of the coordinates when the &
      &base moves by 1 and nothing deforms; 1 if it is left out')]

   character(9), parameter :: matrices(3) = [character(9) :: 'mass', 'damping', 'stiffness']

contains

   !> Reads &structure, with the matrices of its files. What needs the number of coordinates is
   !! checked by `read_parts`.
   subroutine read_structure(path, group, structure)
      !> The file of the namelist; empty if there is none.
      character(*), intent(in) :: path
      !> The group as read from the file.
      type(group_type), intent(in) :: group
      !> Its values, or its first fault.
      type(values_type), intent(out) :: structure
      real(wp), allocatable :: numbers(:)
      character(:), allocatable :: file, full, message, name
      integer :: i

      call read_values('structure', structure_keys, group, structure)
      do i = 1, size(matrices)
         if (len(structure%fault) > 0) return
         name = trim(matrices(i))
         if (.not. structure%has(name//'_file')) cycle
         call structure%text(name//'_file', file)
         call beside(path, file, full)
         call read_matrix(full, most_coordinates, numbers, message)
         if (len(message) > 0) then
            call structure%refuse(name//'_file', full//': '//brief(message))
            return
         end if
         call structure%set(name, numbers)
      end do
   end subroutine read_structure

   !> Reads the gaps and the load of a structure, and checks all of them.
   subroutine read_parts(path, groups, structure, parts, coordinates)
      !> The file of the namelist; empty if there is none.
      character(*), intent(in) :: path
      !> The groups after &structure that belong to it.
      type(group_type), intent(in) :: groups(:)
      !> In: as read. Out: complete, or with a fault.
      type(values_type), intent(inout) :: structure
      !> Its gaps and then its load, complete, or the first of them with a fault.
      type(values_type), allocatable, intent(out) :: parts(:)
      !> Number of coordinates.
      integer, intent(out) :: coordinates
      integer :: order(size(groups)), i, points
      logical :: gaps(size(groups))

      gaps = is_gap(groups)
      order = [pack([(i, i=1, size(groups))], gaps), pack([(i, i=1, size(groups))], .not. gaps)]
      allocate (parts(size(groups)))
      do i = 1, size(groups)
         associate (group => groups(order(i)))
            if (group%name == 'gap') then
               call read_values('gap', gap_keys, group, parts(i))
            else
               call read_values('load', load_keys, group, parts(i))
            end if
         end associate
      end do
      do i = 1, size(parts)
         if (len(parts(i)%fault) > 0) return
      end do
      call find_coordinates(structure, parts, coordinates)
      if (len(structure%fault) == 0) call check_matrices(structure, coordinates)
      if (len(structure%fault) > 0) return
      points = coordinates
      if (structure%has('frequencies')) points = size(structure%numbers('shapes'))/coordinates
      do i = 1, size(parts)
         if (parts(i)%name == 'gap') then
            call check_gap(parts(i), points)
         else
            call check_load(parts(i), coordinates)
            call complete_record(path, structure, coordinates, parts(i))
         end if
      end do
   end subroutine read_parts

   !> Which groups are gaps.
   pure function is_gap(groups) result(mask)
      !> Some groups.
      type(group_type), intent(in) :: groups(:)
      logical :: mask(size(groups))
      integer :: i

      mask = [(groups(i)%name == 'gap', i=1, size(groups))]
   end function is_gap

   !> Finds the number n of coordinates. A list of 4 numbers is the diagonal of 4 coordinates, or
   !! the matrix of 2. All lists together leave one choice, or else the direction of the first gap
   !! decides.
   pure subroutine find_coordinates(structure, parts, n)
      !> In: as read. Out: with a fault if its lists do not fit together.
      type(values_type), intent(inout) :: structure
      !> Its gaps and load.
      type(values_type), intent(in) :: parts(:)
      !> The number.
      integer, intent(out) :: n
      integer :: allowed(2), i, length, root

      if (structure%has('frequencies')) then
         n = size(structure%numbers('frequencies'))
         length = size(structure%numbers('shapes'))
         if (size(structure%numbers('damping_ratios')) /= n) then
            call structure%refuse('damping_ratios', 'there are '//whole(n)//' frequencies')
         else if (modulo(length, n) /= 0) then
            call structure%refuse('shapes', 'there are '//whole(n)//' frequencies and '// &
               whole(length)//' numbers')
         end if
         return
      end if
      n = 0
      allowed = 0
      do i = 1, size(matrices)
         if (.not. structure%has(trim(matrices(i)))) cycle
         length = size(structure%numbers(trim(matrices(i))))
         root = nint(sqrt(real(length, wp)))
         if (root**2 /= length) root = 0
         if (length > most_coordinates) length = 0
         if (i == 1) then
            allowed = [length, root]
         else
            where (allowed /= length .and. allowed /= root) allowed = 0
         end if
         if (all(allowed == 0)) then
            if (i == 1) then
               call structure%refuse(trim(given_as(structure, i)), 'it has '//whole(size( &
                  structure%numbers('mass')))//' numbers')
            else
               call structure%refuse(trim(given_as(structure, i)), 'it has '//whole(size( &
                  structure%numbers(trim(matrices(i)))))//' numbers, which does not fit the '// &
                  whole(size(structure%numbers('mass')))//' of mass')
            end if
            return
         end if
      end do
      n = maxval(allowed)
      if (all(allowed > 0) .and. size(parts) > 0) then
         if (parts(1)%name == 'gap') then
            if (any(allowed == size(parts(1)%numbers('direction')))) n = &
               size(parts(1)%numbers('direction'))
         end if
      end if
   end subroutine find_coordinates

   !> The key with which a matrix was given.
   pure function given_as(structure, i) result(name)
      !> &structure.
      type(values_type), intent(in) :: structure
      !> Place of the matrix in `matrices`.
      integer, intent(in) :: i
      character(24) :: name

      name = matrices(i)
      if (structure%has(trim(matrices(i))//'_file')) name = trim(matrices(i))//'_file'
   end function given_as

   !> Checks the matrices, and completes them: each is a diagonal, or else the whole symmetric
   !! matrix, and files are replaced by what they hold.
   pure subroutine check_matrices(structure, n)
      !> In and out: &structure.
      type(values_type), intent(inout) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      real(wp), allocatable :: matrix(:, :)
      real(wp) :: apart, least, scale
      character(:), allocatable :: name
      integer :: i, j, k, at(2)

      if (structure%has('frequencies')) return
      do i = 1, size(matrices)
         name = trim(matrices(i))
         if (.not. structure%has(name)) then
            call structure%set(name, spread(0.0_wp, 1, n))
            cycle
         end if
         matrix = as_matrix(structure%numbers(name), n)
         scale = maxval(abs(matrix))
         at = maxloc(abs(matrix - transpose(matrix)))
         apart = abs(matrix(at(1), at(2)) - matrix(at(2), at(1)))
         if (apart > 1.0e-12_wp*scale) then
            j = minval(at)
            k = maxval(at)
            call structure%refuse(trim(given_as(structure, i)), 'row '//whole(j)//', column '// &
               whole(k)//' holds '//trim(number_text(matrix(j, k), .false.))//', and row '// &
               whole(k)//', column '//whole(j)//' '//trim(number_text(matrix(k, j), .false.)))
            return
         end if
         matrix = 0.5_wp*(matrix + transpose(matrix))
         call least_eigenvalue(matrix, least)
         if (i == 1 .and. .not. least > 0) then
            call structure%refuse(trim(given_as(structure, i)), 'it must be positive definite, and &
               &its least eigenvalue is '//trim(number_text(least, .false., 3)))
            return
         else if (least < -1.0e-12_wp*scale*n) then
            call structure%refuse(trim(given_as(structure, i)), &
               'it must have no negative eigenvalue, &
               &and the least one is '//trim(number_text(least, .false., 3)))
            return
         end if
         call structure%set(name, shortest(matrix))
      end do
      do i = 1, size(matrices)
         call structure%drop(trim(matrices(i))//'_file')
      end do
   end subroutine check_matrices

   !> A matrix from its diagonal or from all its numbers.
   pure function as_matrix(numbers, n) result(matrix)
      !> n or n*n numbers.
      real(wp), intent(in) :: numbers(:)
      !> Number of rows.
      integer, intent(in) :: n
      real(wp) :: matrix(n, n)
      integer :: i

      if (size(numbers) == n) then
         matrix = 0
         do i = 1, n
            matrix(i, i) = numbers(i)
         end do
      else
         matrix = transpose(reshape(numbers, [n, n]))
      end if
   end function as_matrix

   !> The diagonal of a matrix if all else is 0, or else all its numbers.
   pure function shortest(matrix) result(numbers)
      !> (n, n) A symmetric matrix.
      real(wp), intent(in) :: matrix(:, :)
      real(wp), allocatable :: numbers(:)
      integer :: i

      if (is_diagonal(matrix)) then
         numbers = [(matrix(i, i), i=1, size(matrix, 1))]
      else
         numbers = [matrix]
      end if
   end function shortest

   !> Whether all numbers outside the diagonal are 0.
   pure logical function is_diagonal(matrix)
      !> (n, n)
      real(wp), intent(in) :: matrix(:, :)
      integer :: i

      is_diagonal = .true.
      do i = 1, size(matrix, 1)
         is_diagonal = is_diagonal .and. all(abs(matrix(:i - 1, i)) <= 0) .and. &
            all(abs(matrix(i + 1:, i)) <= 0)
      end do
   end function is_diagonal

   !> The least eigenvalue of a symmetric matrix.
   pure subroutine least_eigenvalue(matrix, least)
      !> (n, n)
      real(wp), intent(in) :: matrix(:, :)
      !> The eigenvalue; -huge if it cannot be computed.
      real(wp), intent(out) :: least
      real(wp), allocatable :: a(:, :), unit(:, :), values(:), work(:)
      integer :: i, info, n

      n = size(matrix, 1)
      if (is_diagonal(matrix)) then
         least = minval([(matrix(i, i), i=1, n)])
         return
      end if
      allocate (a, source=matrix)
      allocate (unit(n, n), source=0.0_wp)
      do i = 1, n
         unit(i, i) = 1
      end do
      allocate (values(n), work(64*n))
      call dsygv(1, 'N', 'U', n, a, n, unit, n, values, work, size(work), info)
      least = merge(values(1), -huge(least), info == 0)
   end subroutine least_eigenvalue

   !> Checks a gap.
   pure subroutine check_gap(gap, points)
      !> The group.
      type(values_type), intent(inout) :: gap
      !> Number of coordinates, or of points.
      integer, intent(in) :: points

      if (size(gap%numbers('direction')) /= points) then
         call gap%refuse('direction', 'it has '//whole(size(gap%numbers('direction')))//', not '// &
            whole(points))
      else if (all(abs(gap%numbers('direction')) <= 0)) then
         call gap%refuse('direction')
      end if
      if (.not. gap%has('law_speeds')) return
      associate (speeds => gap%numbers('law_speeds'))
         if (any(speeds(2:) <= speeds(:size(speeds) - 1))) call gap%refuse('law_speeds')
         if (size(gap%numbers('law_values')) /= size(speeds)) call gap%refuse('law_values', &
            'there are '//whole(size(speeds))//' law_speeds')
      end associate
   end subroutine check_gap

   !> Checks a load.
   pure subroutine check_load(load, coordinates)
      !> The group.
      type(values_type), intent(inout) :: load
      !> Number of coordinates.
      integer, intent(in) :: coordinates
      character(8), parameter :: names(3) = [character(8) :: 'cosine', 'sine', 'constant'], &
         of_record(4) = [character(8) :: 'step', 'acts_on', 'weights', 'base']
      logical :: good
      integer :: i, length

      do i = 1, size(names)
         if (.not. load%has(trim(names(i)))) cycle
         length = size(load%numbers(trim(names(i))))
         good = modulo(length, coordinates) == 0
         if (i == 3) good = length == coordinates
         if (.not. good) call load%refuse(trim(names(i)), 'it has '//whole(length)// &
            ' numbers for '//whole(coordinates)//' coordinates')
      end do
      if (load%has('record') .or. load%has('record_file')) return
      if (.not. any([(load%has(trim(names(i))), i=1, 3)])) call load%refuse('constant', &
         'or give cosine or sine')
      do i = 1, size(of_record)
         call load%forbid(trim(of_record(i)), ': it goes with record or record_file')
      end do
   end subroutine check_load

   !> Reads the file of a record, checks the record, and replaces the motion of a base by its
   !! weights.
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

   !> The number of columns of a record, by the keys beside it, which are checked.
   subroutine count_columns(load, n, columns, why)
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      !> Number of coordinates.
      integer, intent(in) :: n
      !> Number of columns.
      integer, intent(out) :: columns
      !> What tells it, as the end of a message.
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
            call load%refuse('acts_on', 'there are '//counted(n, 'coordinate'))
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
            .false.))//', as samples start at 0 and follow each other by the step '// &
            trim(number_text(step, .false.))
         if (.not. load%has('step')) call load%set('step', [step])
      end if
      if (len(message) > 0) then
         call load%refuse('record_file', full//': '//brief(message))
      else
         call load%set('record', numbers)
      end if
   end subroutine read_record_file

   !> Replaces the motion of a base by the forces for 1 in each column: -M d for its acceleration,
   !! K d and C d for its displacement and velocity.
   subroutine set_base(structure, n, load)
      !> &structure, complete.
      type(values_type), intent(in) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      !> In and out: &load.
      type(values_type), intent(inout) :: load
      real(wp) :: matrices(n, n, 3), weights(n, 2)
      real(wp), allocatable :: d(:)
      integer :: columns, i

      if (.not. load%has('base_direction')) then
         if (structure%has('frequencies')) call load%refuse('base_direction', &
            'coordinates that are amplitudes of modes need it')
         call load%set('base_direction', spread(1.0_wp, 1, n))
      end if
      allocate (d, source=load%numbers('base_direction'))
      call matrices_of(structure, n, matrices)
      columns = merge(1, 2, load%is('base', 'acceleration'))
      weights = 0
      ! coordinate by coordinate, so that the digits do not depend on a library
      do i = 1, n
         if (columns == 1) then
            weights(:, 1) = weights(:, 1) - d(i)*matrices(:, i, 1)
         else
            weights(:, 1) = weights(:, 1) + d(i)*matrices(:, i, 3)
            weights(:, 2) = weights(:, 2) + d(i)*matrices(:, i, 2)
         end if
      end do
      call load%set('weights', [weights(:, :columns)])
      call load%drop('base')
      call load%drop('base_direction')
   end subroutine set_base

   !> The structure and the load of a case.
   pure subroutine structure_of(case, structure, load)
      !> A case with a structure.
      type(case_type), intent(in) :: case
      !> M, C, K and the gaps.
      type(structure_type), intent(out) :: structure
      !> The load; without harmonics its frequency is 0.
      type(load_type), intent(out) :: load
      real(wp), allocatable :: matrices(:, :, :), directions(:, :), gap_values(:, :), &
         shapes(:, :), direction(:), law(:), samples(:, :), weights(:, :)
      integer :: gaps, i, j, n, harmonics

      n = case%coordinates
      gaps = count([(case%parts(i)%name == 'gap', i=1, size(case%parts))])
      allocate (matrices(n, n, 3))
      call matrices_of(case%system, n, matrices)
      associate (s => case%system)
         if (s%has('frequencies')) shapes = reshape(s%numbers('shapes'), &
            [n, size(s%numbers('shapes'))/n])
      end associate
      allocate (directions(n, gaps), source=0.0_wp)
      allocate (gap_values(6 + 2*most_points(case%parts(:gaps)), gaps), source=0.0_wp)
      do i = 1, gaps
         associate (gap => case%parts(i))
            direction = gap%numbers('direction')
            if (allocated(shapes)) then
               ! point by point, so that the digits do not depend on a library
               do j = 1, size(direction)
                  directions(:, i) = directions(:, i) + direction(j)*shapes(:, j)
               end do
            else
               directions(:, i) = direction
            end if
            call law_of(gap, law)
            gap_values(1, i) = gap%number('opening')
            gap_values(2:1 + size(law), i) = law
         end associate
      end do
      structure = new_structure(matrices, directions, gap_values)
      harmonics = 0
      allocate (load%constant(n), source=0.0_wp)
      do i = gaps + 1, size(case%parts)
         associate (group => case%parts(i))
            if (group%has('cosine')) harmonics = size(group%numbers('cosine'))/n
            if (group%has('sine')) harmonics = max(harmonics, size(group%numbers('sine'))/n)
            if (harmonics > 0) load%frequency = group%number('frequency')
            if (group%has('constant')) load%constant = group%numbers('constant')
         end associate
      end do
      allocate (load%cosine(n, harmonics), load%sine(n, harmonics), source=0.0_wp)
      do i = gaps + 1, size(case%parts)
         associate (group => case%parts(i))
            if (group%has('cosine')) load%cosine = padded(group%numbers('cosine'), n, harmonics)
            if (group%has('sine')) load%sine = padded(group%numbers('sine'), n, harmonics)
         end associate
      end do
      if (.not. case%parts(size(case%parts))%has('record')) return
      load%step = case%parts(size(case%parts))%number('step')
      call record_of(case, samples, weights)
      allocate (load%record(n, size(samples, 2)), source=0.0_wp)
      do j = 1, size(weights, 2)
         do i = 1, n
            if (abs(weights(i, j)) > 0) load%record(i, :) = load%record(i, :) &
               + weights(i, j)*samples(j, :)
         end do
      end do
   end subroutine structure_of

   !> M, C and K.
   pure subroutine matrices_of(structure, n, matrices)
      !> &structure, complete.
      type(values_type), intent(in) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      !> (n, n, 3)
      real(wp), intent(out) :: matrices(:, :, :)
      real(wp), allocatable :: omega(:)

      if (structure%has('frequencies')) then
         omega = structure%numbers('frequencies')
         matrices(:, :, 1) = as_matrix(spread(1.0_wp, 1, n), n)
         matrices(:, :, 2) = as_matrix(2*structure%numbers('damping_ratios')*omega, n)
         matrices(:, :, 3) = as_matrix(omega**2, n)
      else
         matrices(:, :, 1) = as_matrix(structure%numbers('mass'), n)
         matrices(:, :, 2) = as_matrix(structure%numbers('damping'), n)
         matrices(:, :, 3) = as_matrix(structure%numbers('stiffness'), n)
      end if
   end subroutine matrices_of

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

   !> The largest number of points of the tables of restitution of some gaps.
   pure integer function most_points(gaps) result(most)
      !> The gaps.
      type(values_type), intent(in) :: gaps(:)
      integer :: i

      most = 0
      do i = 1, size(gaps)
         if (gaps(i)%has('law_speeds')) most = max(most, size(gaps(i)%numbers('law_speeds')))
      end do
   end function most_points

   !> The law of restitution of a gap, as `new_structure` takes it.
   pure subroutine law_of(gap, law)
      !> The gap.
      type(values_type), intent(in) :: gap
      !> Kind and numbers.
      real(wp), allocatable, intent(out) :: law(:)

      if (gap%is('law', 'power')) then
         law = [real(power_law, wp), gap%number('restitution'), gap%number('law_speed'), &
            gap%number('law_exponent'), gap%number('law_sharpness')]
      else if (gap%is('law', 'table')) then
         law = [real(table_law, wp), real(size(gap%numbers('law_speeds')), wp), &
            gap%numbers('law_speeds'), gap%numbers('law_values')]
      else
         law = [real(constant_law, wp), gap%number('restitution')]
      end if
   end subroutine law_of

   !> Amplitudes with zeros for further harmonics.
   pure function padded(numbers, n, harmonics) result(amplitudes)
      !> Harmonic by harmonic.
      real(wp), intent(in) :: numbers(:)
      !> Numbers of coordinates and of harmonics.
      integer, intent(in) :: n, harmonics
      real(wp) :: amplitudes(n, harmonics)

      amplitudes = reshape(numbers, [n, harmonics], pad=[0.0_wp])
   end function padded

end module vi_structure_groups
