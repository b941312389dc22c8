!> The tables of a structure, its gaps and its load in a result.
module vi_structure_tables
   use vi_kinds, only: wp
   use vi_restitution, only: power_law, restitution_type, table_law
   use vi_structure, only: load_type, structure_type
   use vi_structure_path, only: change_type
   use vi_study, only: column_type, result_type, truths, wholes, words
   implicit none (type, external)
   private

   public :: put_path, put_structure, set_unit

   !> The columns of these tables.
   type(column_type), parameter, public :: structure_columns(*) = [ &
      column_type('gaps', 'opening', unit='F0/K', listed=.false., &
      meaning='opening of the gap at q = 0'), &
      column_type('gaps', 'restitution', listed=.false., &
      meaning='coefficient of restitution; with a law, its value at approach speed 0'), &
      column_type('gaps', 'law', words, words='constant,power,table,stop,pushing,friction', &
      listed=.false., meaning='law of restitution, or kind of another element: a stop, a stop that &
      &cannot pull, or friction'), &
      column_type('gaps', 'law_numbers', each='law_number', listed=.false., &
      meaning='speed, exponent and sharpness of a power law; stiffness, damping and preload of a &
      &stop; slip, stick and speed of friction; else 0'), &
      column_type('law_points', 'speed', unit='omega F0/K', listed=.false., &
      meaning='approach speed of a table'), &
      column_type('law_points', 'restitution', listed=.false., &
      meaning='coefficient of restitution there'), &
      column_type('gaps', 'direction', each='coordinate', listed=.false., &
      meaning='direction in which the gap closes'), &
      column_type('matrices', 'mass', each='coordinate', listed=.false., meaning='mass matrix'), &
      column_type('matrices', 'damping', each='coordinate', listed=.false., &
      meaning='damping matrix'), &
      column_type('matrices', 'stiffness', each='coordinate', listed=.false., &
      meaning='stiffness matrix'), &
      column_type('matrices', 'constant', listed=.false., meaning='constant forces'), &
      column_type('harmonics', 'cosine', each='coordinate', listed=.false., &
      meaning='cosine part of the harmonic of the load'), &
      column_type('harmonics', 'sine', each='coordinate', listed=.false., &
      meaning='sine part of the harmonic of the load')]

   !> The columns of the entries that change along a branch or over a zone.
   type(column_type), parameter, public :: path_columns(*) = [ &
      column_type('path', 'axis', wholes, listed=.false., &
      meaning='which parameter changes the entry, 1 or 2'), &
      column_type('path', 'entry', wholes, each='part', listed=.false., &
      meaning='kind of the entry (1 mass, 2 damping, 3 stiffness, 4 direction, 5 opening, 6 &
      &restitution, 7 frequency, 8 cosine, 9 sine, 10 constant) and its place, from 1'), &
      column_type('path', 'chebyshev', truths, listed=.false., &
      meaning='whether the series consists of Chebyshev polynomials over the bounds; else of &
      &powers'), &
      column_type('path', 'series', each='degree', listed=.false., &
      meaning='coefficients of the entry as a function of the parameter')]

contains

   !> Sets the unit of the values of a parameter, in which tables show them if the structure has
   !! `scales`.
   pure subroutine set_unit(result, table, column, parameter)
      !> In and out: without these values yet.
      type(result_type), intent(inout) :: result
      !> Their table and column.
      character(*), intent(in) :: table, column
      !> The parameter by its name, which may end with a number, as opening_0.
      character(*), intent(in) :: parameter
      character(16) :: unit

      associate (name => parameter(:scan(parameter//'_', '_') - 1), &
         about => result%columns(result%place(table, column))%column)
         unit = ''
         if (name == 'opening' .or. name == 'clearance') unit = 'F0/K'
         if (name == 'slip' .or. name == 'stick') unit = 'F0'
         if (name == 'speed') unit = 'omega F0/K'
         if (name == 'contact') unit = 'K'
         about%unit = unit
         if (name == 'frequency') about%meaning = 'frequency ratio'
      end associate
   end subroutine set_unit

   !> Fills the table of the entries that change.
   pure subroutine put_path(result, changes)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The parameters.
      type(change_type), intent(in) :: changes(:)
      integer, allocatable :: axis(:), entries(:, :), chebyshev(:)
      real(wp), allocatable :: series(:, :)
      integer :: degree, i, k, m, n

      n = sum([(size(changes(k)%entries, 2), k=1, size(changes))])
      degree = maxval([(ubound(changes(k)%series, 1), k=1, size(changes))])
      allocate (axis(n), entries(3, n), chebyshev(n))
      allocate (series(0:degree, n), source=0.0_wp)
      n = 0
      do k = 1, size(changes)
         m = ubound(changes(k)%series, 1)
         do i = 1, size(changes(k)%entries, 2)
            n = n + 1
            axis(n) = k
            entries(:, n) = changes(k)%entries(:, i)
            chebyshev(n) = merge(1, 0, changes(k)%chebyshev)
            series(:m, n) = changes(k)%series(:, i)
         end do
      end do
      call result%open('path', 'place', [n])
      call result%put('path', 'axis', axis)
      call result%put('path', 'entry', [entries])
      call result%put('path', 'chebyshev', chebyshev)
      call result%put('path', 'series', [series])
   end subroutine put_path

   !> Fills the tables of the structure, its gaps and its load.
   pure subroutine put_structure(result, structure, load)
      !> The result.
      type(result_type), intent(inout) :: result
      !> The structure and its load.
      type(structure_type), intent(in) :: structure
      !> As in `structure`.
      type(load_type), intent(in) :: load
      real(wp), allocatable :: numbers(:, :)
      integer, allocatable :: points(:)
      integer :: i

      associate (n => size(structure%mass, 1), gaps => size(structure%openings), &
         harmonics => size(load%sine, 2))
         call result%open('gaps', 'number', [gaps])
         allocate (points(gaps), numbers(3, gaps))
         do i = 1, gaps
            points(i) = 0
            numbers(:, i) = 0
            if (structure%laws(i)%kind == power_law) numbers(:, i) = structure%laws(i)%numbers(2:)
            if (structure%laws(i)%kind > table_law) numbers(:, i) = structure%laws(i)%numbers(:3)
            if (structure%laws(i)%kind == table_law) points(i) = size(structure%laws(i)%speeds)
         end do
         call result%put('gaps', 'law', structure%laws%kind + 1)
         call result%put('gaps', 'law_numbers', [numbers])
         call result%open('law_points', 'law_point', [sum(points)], 'gaps', &
            [(spread(i, 1, points(i)), i=1, gaps)])
         call result%put('law_points', 'speed', [(points_of(structure%laws(i), .true.), i=1, gaps)])
         call result%put('law_points', 'restitution', [(points_of(structure%laws(i), .false.), &
            i=1, gaps)])

         call result%put('gaps', 'opening', structure%openings)
         call result%put('gaps', 'restitution', structure%restitution)
         call result%put('gaps', 'direction', [structure%directions], n)
         call result%open('matrices', 'row', [n])
         call result%put('matrices', 'mass', [structure%mass])
         call result%put('matrices', 'damping', [structure%damping])
         call result%put('matrices', 'stiffness', [structure%stiffness])
         call result%put('matrices', 'constant', load%constant)
         call result%open('harmonics', 'harmonic', [harmonics])
         call result%put('harmonics', 'cosine', [load%cosine], n)
         call result%put('harmonics', 'sine', [load%sine], n)
      end associate
   end subroutine put_structure

   !> The points of a table of restitution.
   pure function points_of(law, of_speeds) result(values)
      !> The law.
      type(restitution_type), intent(in) :: law
      !> Whether to give the speeds, else the coefficients.
      logical, intent(in) :: of_speeds
      real(wp), allocatable :: values(:)

      allocate (values(0))
      if (law%kind /= table_law) return
      values = law%values
      if (of_speeds) values = law%speeds
   end function points_of

end module vi_structure_tables
