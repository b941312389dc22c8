!> The group &structure: its matrices, given as lists, in files, or by modes.
module vi_structure_matrices
   use vi_eigen_routines, only: dsygv
   use vi_key, only: a_word, key_type
   use vi_kinds, only: wp
   use vi_matrix_file, only: beside, read_matrix
   use vi_namelist, only: group_type
   use vi_structure, only: is_extreme
   use vi_text, only: brief, counted, number_text, whole
   use vi_units, only: are_units, forces, lengths, make_plain, times
   use vi_values, only: read_values, values_type
   implicit none (type, external)
   private

   public :: check_matrices, check_outputs, find_coordinates, matrices_of, output_rows, &
      read_structure

   !> Largest number of coordinates of a structure, and of gaps.
   integer, parameter, public :: most_coordinates = 500
   !> Largest number of numbers of a matrix.
   integer, parameter, public :: most_numbers = most_coordinates**2

   !> Largest modulus of a number of a matrix, and of a frequency, a damping ratio or a shape.
   real(wp), parameter :: largest = 1.0e100_wp, largest_modal = 1.0e40_wp

   !> Most outputs.
   integer, parameter :: most_outputs = 100
   character(*), parameter :: output_takes = 'different names of at most 23 letters, digits and _ &
      &that start with a letter; not time, kind, gap, phase, speed, impulse, q_... or ..._dot'

   character(*), parameter :: matrix_takes = 'n numbers (the diagonal) or n*n numbers (a symmetric &
      &matrix, row by row) from -1e100 to 1e100, with n at most 500'
   character(*), parameter :: file_takes = 'a Matrix Market file (real, general or symmetric) or a &
      &NumPy file (.npy, float64), with a symmetric matrix of at most 500 rows or its diagonal, of &
      &numbers from -1e100 to 1e100'

   type(key_type), parameter, public :: structure_keys(*) = [ &
      key_type('mass', most=most_numbers, low=-largest, high=largest, takes=matrix_takes, &
      or='mass_file', never='frequencies', &
      meaning='mass matrix M of M q'''' + C q'' + K q = f, positive definite'), &
      key_type('damping', most=most_numbers, low=-largest, high=largest, takes=matrix_takes, &
      may_miss=.true., or='damping_file', never='frequencies', &
      meaning='damping matrix C, without negative eigenvalues; 0 if it is left out'), &
      key_type('stiffness', most=most_numbers, low=-largest, high=largest, takes=matrix_takes, &
      may_miss=.true., or='stiffness_file', never='frequencies', &
      meaning='stiffness matrix K, without negative eigenvalues; 0 if it is left out'), &
      key_type('mass_file', a_word, takes=file_takes, may_miss=.true., or='mass', &
      never='frequencies', meaning='file with M; a relative path starts from &
      &the folder of the namelist'), &
      key_type('damping_file', a_word, takes=file_takes, may_miss=.true., or='damping', &
      never='frequencies', meaning='file with C'), &
      key_type('stiffness_file', a_word, takes=file_takes, may_miss=.true., or='stiffness', &
      never='frequencies', meaning='file with K'), &
      key_type('frequencies', most=most_coordinates, low=0.0_wp, high=largest_modal, &
      may_miss=.true., takes='one number from 0 to 1e40 for each mode, at most 500', &
      meaning='circular frequencies of modes, in place of matrices; the coordinates are their &
      &amplitudes'), &
      key_type('damping_ratios', most=most_coordinates, low=0.0_wp, high=largest_modal, &
      only='frequencies', takes='one number from 0 to 1e40 for each mode', &
      meaning='damping ratio of each mode'), &
      key_type('shapes', most=most_numbers, low=-largest_modal, high=largest_modal, &
      only='frequencies', takes='one number from -1e40 to 1e40 for each mode, point by point', &
      meaning='mass-normalised shapes of the modes at the points to which gaps refer'), &
      key_type('outputs', a_word, most=most_outputs, may_miss=.true., takes=output_takes, &
      meaning='names of outputs, which results then show in addition to the coordinates'), &
      key_type('output_rows', most=most_outputs*most_coordinates, low=-largest_modal, &
      high=largest_modal, only='outputs', &
      takes='one number from -1e40 to 1e40 for each coordinate, output by output', &
      meaning='weight of each coordinate in each output; with modes the shapes at its point'), &
      key_type('simultaneous', a_word, may_miss=.true., words='newton sequence', &
      meaning='law of impacts where coupled gaps close at the same instant: Newton''s law at all &
      &of &
      &them at once, or impacts one after the other; an error if it is left out'), &
      key_type('scales', least=3, most=3, low=0.0_wp, above=.true., may_miss=.true., &
      never='frequencies', &
      takes='mass M, stiffness K and force F0, in the units of unit_names', &
      meaning='scales of dimensionless numbers (lengths over F0/K, times over sqrt(M/K)), for &
      &tables and pictures in physical units'), &
      key_type('unit_names', a_word, may_miss=.true., only='scales', &
      takes='units of length, force and time, as ''mm N s'', of '//lengths//', '//forces// &
      ' and '//times, meaning='units of scales; m N s if left out')]

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
      if (len(structure%fault) == 0 .and. structure%has('unit_names')) then
         call structure%text('unit_names', name)
         call make_plain(name)
         if (.not. are_units(name)) call structure%refuse('unit_names')
         call structure%set_word('unit_names', name)
      end if
      do i = 1, size(matrices)
         if (len(structure%fault) > 0) return
         name = trim(matrices(i))
         if (.not. structure%has(name//'_file')) cycle
         call structure%text(name//'_file', file)
         call beside(path, file, full)
         call read_matrix(full, most_coordinates, numbers, message)
         if (len(message) == 0 .and. any(abs(numbers) > largest)) message = &
            'it contains the number '//trim(number_text(numbers(maxloc(abs(numbers), 1)), .false.))
         if (len(message) > 0) then
            call structure%refuse(name//'_file', full//': '//brief(message))
            return
         end if
         call structure%set(name, numbers)
      end do
   end subroutine read_structure

   !> Finds the number n of coordinates. A list of 4 numbers is the diagonal of 4 coordinates, or
   !! the matrix of 2. All lists together leave one choice, or else the direction of the first gap
   !! decides.
   pure subroutine find_coordinates(structure, parts, n)
      !> In: as read. Out: with a fault if its lists do not fit together.
      type(values_type), intent(inout) :: structure
      !> Its gaps, at least one, and then its load.
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
               call structure%refuse(trim(given_as(structure, i)), 'it has '//counted(size( &
                  structure%numbers('mass')), 'number'))
            else
               call structure%refuse(trim(given_as(structure, i)), 'it has '//counted(size( &
                  structure%numbers(trim(matrices(i)))), 'number')//', which does not fit the '// &
                  whole(size(structure%numbers('mass')))//' numbers of mass')
            end if
            return
         end if
      end do
      n = maxval(allowed)
      if (all(allowed > 0)) then
         if (any(allowed == size(parts(1)%numbers('direction')))) n = &
            size(parts(1)%numbers('direction'))
      end if
   end subroutine find_coordinates

   !> The key by which a matrix was given.
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
   !!
   !! Their entries are compared after the coordinates are scaled by the square roots of their
   !! masses, so that what is refused does not depend on the units of any coordinate.
   pure subroutine check_matrices(structure, n)
      !> In and out: &structure.
      type(values_type), intent(inout) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      real(wp), allocatable :: matrix(:, :), scaled(:, :)
      real(wp) :: unit(n), least, own, scale
      character(:), allocatable :: name, rule
      integer :: i, j, k, at(2)

      if (structure%has('frequencies')) return
      unit = 1
      do i = 1, size(matrices)
         name = trim(matrices(i))
         if (.not. structure%has(name)) then
            call structure%set(name, spread(0.0_wp, 1, n))
            cycle
         end if
         matrix = as_matrix(structure%numbers(name), n)
         if (i == 1) call set_units(matrix, unit)
         scaled = matrix*spread(unit, 1, n)*spread(unit, 2, n)
         scale = maxval(abs(scaled))
         at = maxloc(abs(scaled - transpose(scaled)))
         if (abs(scaled(at(1), at(2)) - scaled(at(2), at(1))) > 1.0e-12_wp*scale) then
            j = minval(at)
            k = maxval(at)
            call structure%refuse(trim(given_as(structure, i)), 'row '//whole(j)//', column '// &
               whole(k)//' holds '//trim(number_text(matrix(j, k), .false.))//', and row '// &
               whole(k)//', column '//whole(j)//' '//trim(number_text(matrix(k, j), .false.)))
            return
         end if
         scaled = 0.5_wp*(scaled + transpose(scaled))
         call least_eigenvalue(scaled, least)
         if (i == 1 .and. .not. least > n*epsilon(least)) then
            rule = 'it must be positive definite, and its least eigenvalue is '
         else if (least < -1.0e-12_wp*scale*n) then
            rule = 'it must have no negative eigenvalue, and the least one is '
         else
            rule = ''
         end if
         matrix = 0.5_wp*(matrix + transpose(matrix))
         if (len(rule) > 0) then
            call least_eigenvalue(matrix, own)
            ! the sign may be lost where the units of coordinates differ
            if (own > 0) then
               rule = rule//trim(number_text(least, .false., 3))//' with coordinates scaled by the &
                  &square roots of their masses'
            else
               rule = rule//trim(number_text(own, .false., 3))
            end if
            call structure%refuse(trim(given_as(structure, i)), rule)
            return
         end if
         call structure%set(name, shortest(matrix))
         ! such masses are refused by a simulation; their factors would overflow
         if (i == 1 .and. any([(is_extreme(matrix(j, j)), j=1, n)])) unit = 1
      end do
      do i = 1, size(matrices)
         call structure%drop(trim(matrices(i))//'_file')
      end do
   end subroutine check_matrices

   !> The factors that scale coordinates by the square roots of their masses.
   pure subroutine set_units(mass, unit)
      !> (n, n) M.
      real(wp), intent(in) :: mass(:, :)
      !> (n) In: 1. Out: the factors; still 1 where a mass is not allowed.
      real(wp), intent(inout) :: unit(:)
      integer :: i

      if (any([(.not. mass(i, i) > 0, i=1, size(unit))])) return
      unit = [(1/sqrt(mass(i, i)), i=1, size(unit))]
   end subroutine set_units

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
      !> (n, n) A symmetric matrix.
      real(wp), intent(in) :: matrix(:, :)
      integer :: i

      is_diagonal = .true.
      do i = 1, size(matrix, 1)
         is_diagonal = is_diagonal .and. all(abs(matrix(:i - 1, i)) <= 0)
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

   !> Checks the outputs.
   pure subroutine check_outputs(structure, n)
      !> In and out: &structure.
      type(values_type), intent(inout) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
      character(24) :: names(structure%count_words('outputs'))
      integer :: i

      do i = 1, size(names)
         names(i) = structure%word('outputs', i)
         associate (name => names(i))
            if (len_trim(name) == len(name) .or. scan(name, letters) /= 1 .or. &
               verify(trim(name), letters//'_0123456789') > 0 .or. index(name, 'q_') == 1 .or. &
               index(name, '_dot ') > 0 .or. any(name == [character(24) :: 'time', 'kind', 'gap', &
               'phase', 'speed', 'impulse', names(:i - 1)])) then
               call structure%refuse('outputs')
               return
            end if
         end associate
      end do
      if (size(names) == 0) return
      associate (given => size(structure%numbers('output_rows')))
         if (given /= n*size(names)) call structure%refuse('output_rows', 'there are '// &
            whole(size(names))//' outputs of '//whole(n)//' coordinates, and '//whole(given)// &
            ' numbers')
      end associate
   end subroutine check_outputs

   !> The outputs as rows that give them from the coordinates.
   pure function output_rows(structure, n) result(rows)
      !> &structure, complete.
      type(values_type), intent(in) :: structure
      !> Number of coordinates.
      integer, intent(in) :: n
      !> (outputs, n)
      real(wp), allocatable :: rows(:, :)

      allocate (rows(structure%count_words('outputs'), n))
      if (size(rows, 1) > 0) rows = transpose(reshape(structure%numbers('output_rows'), &
         [n, size(rows, 1)]))
   end function output_rows

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

end module vi_structure_matrices
