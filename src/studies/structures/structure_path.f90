!> Structures and loads as functions of one or two parameters.
!!
!! A parameter is an entry of the structure or its load, a factor of some of them, or any smooth
!! function of a parameter: then the entries that it changes are given as Chebyshev series.
module vi_structure_path
   use vi_kinds, only: wp
   use vi_restitution, only: friction_law, restitution_type, table_law
   use vi_structure, only: load_type, project, structure_type
   use vi_text, only: counted, number_text, whole
   implicit none (type, external)
   private

   public :: change_again, changed, changed_whole, is_odd, keeps_gaps, keeps_matrices, &
      mirror_of, moves_alike, new_change, new_function, opposite_gap, rates_of, reduce, same_law, &
      set_entry, value_at

   !> Kinds of entries: matrices, direction, opening and restitution of a gap, parts of the load,
   !! the numbers of a stop (stiffness, damping, preload) or of friction (slip, stick, speed), and
   !! the motion of a wall.
   integer, parameter :: of_mass = 1, of_damping = 2, of_stiffness = 3, of_direction = 4, &
      of_opening = 5, of_restitution = 6, of_frequency = 7, of_cosine = 8, of_sine = 9, &
      of_constant = 10, of_law = 11, of_wall_cosine = 12, of_wall_sine = 13

   !> Names of other entries: both levels of friction, the stiffness of a stop, the motion of a
   !! wall, and the stick level of friction alone and the speed of its belt.
   integer, parameter :: of_slip = 11, of_contact = 12, of_wall = 13, of_stick = 14, of_speed = 15

   character(*), parameter, public :: parameter_takes = '''frequency'', ''load'', ''constant'', &
      &''damping'' or ''stiffness'' (factors, 1 for the motion), ''opening'' or ''restitution'' &
      &(of all gaps), ''slip'' (of friction, stick in the same ratio), ''stick'', ''speed'' (of &
      &belts), ''contact'' (stiffness of stops) or ''wall'' (factor of the motion of walls, above &
      &0), the same of element J as ''opening_J'', ''mass_I_J'', ''damping_I_J'', &
      &''stiffness_I_J'', all from 0'

   !> How one parameter p changes entries, between its bounds.
   type, public :: change_type
      !> (3, m) Kind of each entry and its place: row and column, coordinate and gap, gap,
      !! coordinate and harmonic, coordinate, or gap and harmonic.
      integer, allocatable :: entries(:, :)
      !> (0:degree, m) Coefficients: in powers of p, or of the Chebyshev polynomials over the
      !! bounds.
      real(wp), allocatable :: series(:, :)
      logical :: chebyshev = .false.
      real(wp) :: low = 0, high = 1
      !> The value of p at the start.
      real(wp) :: start = 0
   end type change_type

   !> A structure and its load at the start, and the parameters that change them.
   type, public :: structure_path_type
      type(structure_type) :: structure
      type(load_type) :: load
      type(change_type), allocatable :: changes(:)
      !> Only motions q = V y, where `part` is V (n, k): `structure` and `load` are those of y, with
      !! the gaps `kept` of the whole structure, and the parameters change the latter.
      real(wp), allocatable :: part(:, :)
      integer, allocatable :: kept(:)
      type(structure_type) :: whole
      type(load_type) :: whole_load
   end type structure_path_type

   !> The derivatives of a structure and its load with respect to a parameter.
   type, public :: rates_type
      !> (gaps) Those of the openings and of the coefficients of restitution at speed 0.
      real(wp), allocatable :: openings(:), restitution(:)
      !> That of the frequency.
      real(wp) :: frequency = 0
      !> (n, 1 + 2 harmonics) Those of the constant forces, the cosines and the sines.
      real(wp), allocatable :: forces(:, :)
      !> (harmonics, gaps) Those of the motions of walls.
      complex(wp), allocatable :: walls(:, :)
      !> Whether the matrices or the directions change; their derivatives are not given.
      logical :: modes = .false.
   end type rates_type

contains

   !> The value of a parameter at a share of the way between its bounds; exact at both bounds.
   pure real(wp) function value_at(change, share) result(value)
      !> The parameter.
      type(change_type), intent(in) :: change
      !> 0 at the lower bound, 1 at the upper one.
      real(wp), intent(in) :: share

      value = change%low + share*(change%high - change%low)
      if (abs(share - 1) <= 0) value = change%high
   end function value_at

   !> The structure and its load at given parameters.
   pure subroutine changed(path, shares, structure, load)
      !> The path.
      type(structure_path_type), intent(in) :: path
      !> Each parameter, as a share of the way between its bounds.
      real(wp), intent(in) :: shares(:)
      !> The structure: M, C, K and its gaps; what follows from them is not set.
      type(structure_type), intent(out) :: structure
      !> The load.
      type(load_type), intent(out) :: load

      call changed_whole(path, shares, structure, load)
      if (allocated(path%part)) call reduce(path%part, path%kept, structure, load)
   end subroutine changed

   !> The same of all motions, also where only a part of them is followed.
   pure subroutine changed_whole(path, shares, structure, load)
      !> The path.
      type(structure_path_type), intent(in) :: path
      !> As in `changed`.
      real(wp), intent(in) :: shares(:)
      !> As in `changed`.
      type(structure_type), intent(out) :: structure
      !> The load.
      type(load_type), intent(out) :: load

      if (allocated(path%part)) then
         structure = path%whole
         load = path%whole_load
      else
         structure = path%structure
         load = path%load
      end if
      call change_again(path, shares, structure, load)
   end subroutine changed_whole

   !> The structure and its load at other parameters.
   pure subroutine change_again(path, shares, structure, load)
      !> The path, of all motions.
      type(structure_path_type), intent(in) :: path
      !> As in `changed`.
      real(wp), intent(in) :: shares(:)
      !> In and out: the structure at any parameters; what follows from its entries is not changed.
      type(structure_type), intent(inout) :: structure
      !> In and out: the load.
      type(load_type), intent(inout) :: load
      integer :: i, k

      ! beyond the bounds, one of which may be damping 0
      structure%may_grow = any(shares < 0 .or. shares > 1)
      do k = 1, size(path%changes)
         do i = 1, size(path%changes(k)%entries, 2)
            call set_entry(structure, load, path%changes(k)%entries(:, i), &
               entry_at(path%changes(k), path%changes(k)%series(:, i), shares(k)))
         end do
      end do
   end subroutine change_again

   !> Whether no parameter changes what `check_structure` derives.
   pure logical function keeps_gaps(path)
      !> The path.
      type(structure_path_type), intent(in) :: path

      ! only with a dashpot a stop may have to pull
      keeps_gaps = .not. allocated(path%part) .and. .not. any_changes(path, [of_mass, &
         of_direction, of_wall_cosine, of_wall_sine], 2)
   end function keeps_gaps

   !> Whether no parameter changes matrices either, nor the stiffness of stops, and no wall moves:
   !! then regimes can be renewed.
   pure logical function keeps_matrices(path)
      !> The path.
      type(structure_path_type), intent(in) :: path

      keeps_matrices = keeps_gaps(path) .and. .not. path%structure%moves .and. &
         .not. any_changes(path, [of_damping, of_stiffness], 1)
   end function keeps_matrices

   !> Whether a parameter changes an entry of some kinds, or a number of the law of a stop.
   pure logical function any_changes(path, kinds, number)
      !> The path.
      type(structure_path_type), intent(in) :: path
      !> Kinds of entries, and the number of the law: 1 stiffness, 2 damping.
      integer, intent(in) :: kinds(:), number
      integer :: i, k

      any_changes = .false.
      do k = 1, size(path%changes)
         associate (entries => path%changes(k)%entries)
            do i = 1, size(entries, 2)
               if (any(kinds == entries(1, i))) any_changes = .true.
               if (entries(1, i) /= of_law .or. entries(3, i) /= number) cycle
               if (path%structure%laws(entries(2, i))%kind /= friction_law) any_changes = .true.
            end do
         end associate
      end do
   end function any_changes

   !> The structure and the load of the motions q = V y: V^T M V, .., V^T G_j and V^T f.
   pure subroutine reduce(part, kept, structure, load)
      !> (n, k) V; the gaps that are kept.
      real(wp), intent(in) :: part(:, :)
      integer, intent(in) :: kept(:)
      !> In and out: M, C, K and gaps; what follows from them is not set.
      type(structure_type), intent(inout) :: structure
      !> In and out: the load.
      type(load_type), intent(inout) :: load
      real(wp) :: across(size(part, 2), size(part, 1)), terms(size(part, 2), size(part, 2))
      real(wp), allocatable :: openings(:), restitution(:), gaps(:, :), reduced(:, :)
      type(restitution_type), allocatable :: laws(:)
      complex(wp), allocatable :: motion(:, :)
      integer :: i

      across = transpose(part)
      call project(structure%mass, part, reduced, terms)
      call move_alloc(reduced, structure%mass)
      call project(structure%damping, part, reduced, terms)
      call move_alloc(reduced, structure%damping)
      call project(structure%stiffness, part, reduced, terms)
      call move_alloc(reduced, structure%stiffness)
      allocate (gaps(size(part, 1), size(kept)), openings(size(kept)), restitution(size(kept)), &
         laws(size(kept)))
      do i = 1, size(kept)
         gaps(:, i) = structure%directions(:, kept(i))
         openings(i) = structure%openings(kept(i))
         restitution(i) = structure%restitution(kept(i))
         laws(i) = structure%laws(kept(i))
      end do
      allocate (motion, source=structure%motion(:, kept))
      call move_alloc(motion, structure%motion)
      structure%directions = matmul(across, gaps)
      call move_alloc(openings, structure%openings)
      call move_alloc(restitution, structure%restitution)
      call move_alloc(laws, structure%laws)
      load%cosine = across_columns(load%cosine)
      load%sine = across_columns(load%sine)
      gaps = across_columns(reshape(load%constant, [size(part, 1), 1]))
      load%constant = gaps(:, 1)
   contains
      !> V^T times a matrix, which the product may replace.
      pure function across_columns(matrix) result(reduced)
         !> (n, m)
         real(wp), intent(in) :: matrix(:, :)
         real(wp) :: reduced(size(part, 2), size(matrix, 2))

         reduced = matmul(across, matrix)
      end function across_columns
   end subroutine reduce

   !> An entry at a value of the parameter.
   pure real(wp) function entry_at(change, series, share) result(value)
      !> The parameter.
      type(change_type), intent(in) :: change
      !> (0:degree) Its coefficients for this entry.
      real(wp), intent(in) :: series(0:)
      !> As in `value_at`.
      real(wp), intent(in) :: share
      real(wp) :: sums(2)

      if (.not. change%chebyshev) then
         value = series(0) + series(1)*value_at(change, share)
         return
      end if
      sums = clenshaw(series(1:), share)
      value = (2*share - 1)*sums(1) - sums(2) + series(0)
   end function entry_at

   !> The derivative of an entry with respect to the share.
   pure real(wp) function entry_rate(change, series, share) result(rate)
      !> The parameter.
      type(change_type), intent(in) :: change
      !> (0:degree) Its coefficients for this entry.
      real(wp), intent(in) :: series(0:)
      !> As in `value_at`.
      real(wp), intent(in) :: share
      real(wp) :: sums(2)
      integer :: i

      if (.not. change%chebyshev) then
         rate = series(1)*(change%high - change%low)
         return
      end if
      ! T_i' = i U_(i - 1), where T_i and U_i are the polynomials of the first and second kind
      sums = clenshaw([(i*series(i), i=1, ubound(series, 1))], share)
      rate = 2*sums(1)
   end function entry_rate

   !> The last two sums of Clenshaw's recurrence for Chebyshev polynomials.
   pure function clenshaw(series, share) result(sums)
      !> Coefficients, of the polynomial of degree 1 first.
      real(wp), intent(in) :: series(:)
      !> As in `value_at`.
      real(wp), intent(in) :: share
      real(wp) :: sums(2)
      integer :: i

      sums = 0
      do i = size(series), 1, -1
         sums = [2*(2*share - 1)*sums(1) - sums(2) + series(i), sums(1)]
      end do
   end function clenshaw

   !> The derivatives of the structure and its load with respect to a parameter, as a share.
   pure subroutine rates_of(path, k, share, rates)
      !> The path.
      type(structure_path_type), intent(in) :: path
      !> Number of the parameter.
      integer, intent(in) :: k
      !> Its value, as a share of the way between its bounds.
      real(wp), intent(in) :: share
      !> The derivatives.
      type(rates_type), intent(out) :: rates
      type(rates_type) :: all
      real(wp) :: rate
      integer :: gaps, harmonics, m, n

      harmonics = size(path%load%sine, 2)
      gaps = size(path%structure%openings)
      n = size(path%load%constant)
      if (allocated(path%part)) then
         gaps = size(path%whole%openings)
         n = size(path%part, 1)
      end if
      allocate (rates%openings(gaps), rates%restitution(gaps), rates%forces(n, 1 + 2*harmonics), &
         source=0.0_wp)
      allocate (rates%walls(size(path%structure%motion, 1), gaps), source=(0.0_wp, 0.0_wp))
      do m = 1, size(path%changes(k)%entries, 2)
         rate = entry_rate(path%changes(k), path%changes(k)%series(:, m), share)
         associate (i => path%changes(k)%entries(2, m), j => path%changes(k)%entries(3, m))
            select case (path%changes(k)%entries(1, m))
            case (of_opening)
               rates%openings(i) = rate
            case (of_restitution)
               rates%restitution(i) = rate
            case (of_frequency)
               rates%frequency = rate
            case (of_constant)
               rates%forces(i, 1) = rate
            case (of_cosine)
               rates%forces(i, 1 + j) = rate
            case (of_sine)
               rates%forces(i, 1 + harmonics + j) = rate
            case (of_wall_cosine)
               rates%walls(j, i) = cmplx(rate, rates%walls(j, i)%im, wp)
            case (of_wall_sine)
               rates%walls(j, i) = cmplx(rates%walls(j, i)%re, -rate, wp)
            case default
               rates%modes = .true.
            end select
         end associate
      end do
      if (.not. allocated(path%part)) return
      all = rates
      rates%openings = all%openings(path%kept)
      rates%restitution = all%restitution(path%kept)
      rates%walls = all%walls(:, path%kept)
      rates%forces = matmul(transpose(path%part), all%forces)
   end subroutine rates_of

   !> Sets an entry.
   pure subroutine set_entry(structure, load, entry, value)
      !> In and out: the structure and the load.
      type(structure_type), intent(inout) :: structure
      !> As in `structure`.
      type(load_type), intent(inout) :: load
      !> (3) Kind and place.
      integer, intent(in) :: entry(3)
      !> Its value.
      real(wp), intent(in) :: value

      associate (i => entry(2), j => entry(3))
         select case (entry(1))
         case (of_mass)
            structure%mass(i, j) = value
            structure%mass(j, i) = value
         case (of_damping)
            structure%damping(i, j) = value
            structure%damping(j, i) = value
         case (of_stiffness)
            structure%stiffness(i, j) = value
            structure%stiffness(j, i) = value
         case (of_direction)
            structure%directions(i, j) = value
         case (of_opening)
            structure%openings(i) = value
         case (of_restitution)
            structure%restitution(i) = value
            structure%laws(i)%numbers(1) = value
         case (of_frequency)
            load%frequency = value
         case (of_cosine)
            load%cosine(i, j) = value
         case (of_sine)
            load%sine(i, j) = value
         case (of_law)
            structure%laws(i)%numbers(j) = value
         case (of_wall_cosine)
            structure%motion(j, i)%re = value
         case (of_wall_sine)
            structure%motion(j, i)%im = -value
         case default
            load%constant(i) = value
         end select
      end associate
   end subroutine set_entry

   !> The value of an entry.
   pure real(wp) function get(structure, load, entry) result(value)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> (3) Kind and place.
      integer, intent(in) :: entry(3)

      associate (i => entry(2), j => entry(3))
         select case (entry(1))
         case (of_mass)
            value = structure%mass(i, j)
         case (of_damping)
            value = structure%damping(i, j)
         case (of_stiffness)
            value = structure%stiffness(i, j)
         case (of_direction)
            value = structure%directions(i, j)
         case (of_opening)
            value = structure%openings(i)
         case (of_restitution)
            value = structure%restitution(i)
         case (of_frequency)
            value = load%frequency
         case (of_cosine)
            value = load%cosine(i, j)
         case (of_sine)
            value = load%sine(i, j)
         case (of_law)
            value = structure%laws(i)%numbers(j)
         case (of_wall_cosine)
            value = structure%motion(j, i)%re
         case (of_wall_sine)
            value = -structure%motion(j, i)%im
         case default
            value = load%constant(i)
         end select
      end associate
   end function get

   !> A parameter from its name.
   pure subroutine new_change(name, bounds, structure, load, change, message, bound)
      !> One of the names of `parameter_takes`.
      character(*), intent(in) :: name
      !> Its bounds.
      real(wp), intent(in) :: bounds(2)
      !> The structure at the start.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The parameter.
      type(change_type), intent(out) :: change
      !> What is wrong with it; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      !> The bound that is wrong, 1 or 2; 0 if the name is.
      integer, intent(out), optional :: bound
      character(:), allocatable :: word
      integer, allocatable :: entries(:, :)
      integer :: places(2), h, i, j, kind, n, gaps
      logical :: factor, good

      if (present(bound)) bound = 0
      n = size(structure%mass, 1)
      gaps = size(structure%openings)
      message = ''
      factor = .false.
      call split(name, word, places, good)
      kind = findloc([character(11) :: 'mass', 'damping', 'stiffness', '', 'opening', &
         'restitution', 'frequency', 'load', '', 'constant', 'slip', 'contact', 'wall', 'stick', &
         'speed'] == word, .true., 1)
      if (kind == 0 .or. len(word) == 0 .or. .not. good) then
         message = 'the structure has no such parameter'
         return
      end if
      select case (kind)
      case (of_opening, of_restitution, of_slip, of_contact, of_wall, of_stick, of_speed)
         if (places(2) >= 0) message = 'it takes one number, that of an element'
         if (places(1) >= gaps) message = 'the structure has '//counted(gaps, trim(merge( &
            'gap, stop or friction element', 'gap                          ', &
            any(structure%laws%kind > table_law))))
         if (len(message) > 0) return
         allocate (entries(3, 0))
         factor = kind == of_wall
         do i = 1, gaps
            if (factor .and. (places(1) < 0 .or. places(1) + 1 == i)) entries = reshape([entries, &
               [(of_wall_cosine, i, h, of_wall_sine, i, h, h=1, size(structure%motion, 1))]], &
               [3, size(entries, 2) + 2*size(structure%motion, 1)])
            if (factor) cycle
            if (.not. has_it(kind, structure%laws(i)%kind)) cycle
            if (places(1) < 0 .or. places(1) + 1 == i) entries = reshape([entries, &
               merge(of_law, kind, kind > of_constant), i, number_of(kind)], [3, size(entries, 2) &
               + 1])
         end do
      case (of_mass, of_damping, of_stiffness)
         if (any(places >= n)) message = 'the structure has '//counted(n, 'coordinate')
         factor = all(places < 0)
         if (any(places < 0) .and. (.not. factor .or. kind == of_mass)) message = &
            'it takes two numbers, row and column'
         if (factor) then
            entries = reshape([((kind, i, j, j=1, i), i=1, n)], [3, n*(n + 1)/2])
         else
            entries = reshape([kind, places(1) + 1, places(2) + 1], [3, 1])
         end if
      case (of_frequency)
         entries = reshape([kind, 0, 0], [3, 1])
      case (of_constant)
         factor = .true.
         entries = reshape([(kind, i, 0, i=1, n)], [3, n])
      case default
         factor = .true.
         associate (h => size(load%sine, 2))
            entries = reshape([((of_cosine, i, j, of_sine, i, j, i=1, n), j=1, h)], [3, 2*h*n])
         end associate
      end select
      if (len(message) == 0 .and. any(kind == [of_frequency, of_constant, of_cosine]) .and. &
         any(places >= 0)) message = 'it takes no numbers'
      if (len(message) > 0) return
      ! a factor changes only what is not 0
      if (factor) entries = nonzero(structure, load, entries)
      if (size(entries) == 0) then
         message = 'it changes nothing in this structure'
         return
      end if
      change%low = bounds(1)
      change%high = bounds(2)
      change%start = 1
      if (.not. factor) change%start = get(structure, load, entries(:, 1))
      allocate (change%series(0:1, size(entries, 2)), source=0.0_wp)
      do i = 1, size(entries, 2)
         change%series(1, i) = 1
         if (factor) change%series(1, i) = get(structure, load, entries(:, i))
         if (factor) cycle
         if (abs(get(structure, load, entries(:, i)) - change%start) > 0) then
            message = 'all gaps must have the same '//word
            return
         end if
      end do
      if (kind == of_slip .and. change%start > 0) call add_stick(structure, entries, change)
      if (kind == of_restitution) then
         if (any(structure%laws(entries(2, :))%kind == table_law)) message = &
            'the restitution of the gap is a table'
      end if
      call move_alloc(entries, change%entries)
      call check_range(kind, factor, change, message, bound)
      if (kind /= of_stick .or. len(message) > 0) return
      if (any([(structure%laws(change%entries(2, i))%numbers(1) > change%low, i=1, &
         size(change%entries, 2))])) then
         message = 'a stick level must be at least the slip level'
         if (present(bound)) bound = 1
      end if
   end subroutine new_change

   !> The place of what a parameter changes among the numbers of a law; 0 if it is none of them.
   pure integer function number_of(kind) result(number)
      !> The kind of the parameter.
      integer, intent(in) :: kind

      number = merge(1, 0, kind > of_constant)
      if (kind == of_stick) number = 2
      if (kind == of_speed) number = 3
   end function number_of

   !> Whether a gap, a stop or friction has what a parameter changes.
   elemental logical function has_it(kind, law) result(has)
      !> The kind of the parameter, and that of the law.
      integer, intent(in) :: kind, law

      select case (kind)
      case (of_opening)
         has = law /= friction_law
      case (of_restitution)
         has = law <= table_law
      case (of_slip, of_stick, of_speed)
         has = law == friction_law
      case default
         has = law > table_law .and. law /= friction_law
      end select
   end function has_it

   !> Adds the stick levels of friction to its slip levels, with the same ratio.
   pure subroutine add_stick(structure, entries, change)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> In and out: the entries.
      integer, allocatable, intent(inout) :: entries(:, :)
      !> In and out: the parameter.
      type(change_type), intent(inout) :: change
      real(wp), allocatable :: series(:, :)
      integer :: i, n

      n = size(entries, 2)
      allocate (series(0:1, 2*n), source=0.0_wp)
      series(1, :n) = 1
      series(1, n + 1:) = [(structure%laws(entries(2, i))%numbers(2)/change%start, i=1, n)]
      entries = reshape([entries, [(of_law, entries(2, i), 2, i=1, n)]], [3, 2*n])
      call move_alloc(series, change%series)
   end subroutine add_stick

   !> Checks that the bounds are values that the parameter can have.
   pure subroutine check_range(kind, factor, change, message, bound)
      !> Kind of entry.
      integer, intent(in) :: kind
      !> Whether the parameter is a factor.
      logical, intent(in) :: factor
      !> The parameter.
      type(change_type), intent(in) :: change
      !> Out: what is wrong, if anything is.
      character(:), allocatable, intent(inout) :: message
      !> Out: the bound that is wrong, 1 or 2.
      integer, intent(inout), optional :: bound

      if (kind == of_restitution .and. .not. (change%low >= 0 .and. change%high <= 1)) then
         message = 'a coefficient of restitution must be from 0 to 1'
         if (present(bound)) bound = merge(2, 1, change%low >= 0)
         return
      else if (kind == of_frequency .and. .not. change%low > 0) then
         message = 'a frequency must be above 0'
      else if (kind == of_slip .and. .not. change%low >= 0) then
         message = 'friction must be at least 0'
      else if (kind == of_contact .and. .not. change%low > 0) then
         message = 'a stiffness of a stop must be above 0'
      else if (kind == of_wall .and. .not. change%low > 0) then
         message = 'this factor must be above 0'
      else if (factor .and. any(kind == [of_damping, of_stiffness]) .and. .not. change%low >= 0) &
         then
         message = 'this factor must be at least 0'
      end if
      if (present(bound) .and. len(message) > 0) bound = 1
   end subroutine check_range

   !> The entries that are not 0.
   pure function nonzero(structure, load, entries) result(kept)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> (3, m)
      integer, intent(in) :: entries(:, :)
      integer, allocatable :: kept(:, :)
      logical :: wanted(size(entries, 2))
      integer :: i

      do i = 1, size(entries, 2)
         wanted(i) = abs(get(structure, load, entries(:, i))) > 0
      end do
      allocate (kept(3, count(wanted)))
      do i = 1, 3
         kept(i, :) = pack(entries(i, :), wanted)
      end do
   end function nonzero

   !> Splits a name such as 'stiffness_0_1' into its word and its numbers.
   pure subroutine split(name, word, places, good)
      !> The name.
      character(*), intent(in) :: name
      !> The word.
      character(:), allocatable, intent(out) :: word
      !> The numbers, -1 where there is none.
      integer, intent(out) :: places(2)
      !> Whether the name has this form.
      logical, intent(out) :: good
      integer :: begin, i, j, next

      places = -1
      good = .true.
      begin = index(name, '_')
      if (begin == 0) begin = len_trim(name) + 1
      word = name(:begin - 1)
      i = 0
      do while (begin <= len_trim(name))
         i = i + 1
         next = index(name(begin + 1:), '_')
         if (next == 0) next = len_trim(name) - begin + 1
         associate (digits => name(begin + 1:begin + next - 1))
            good = i <= 2 .and. len(digits) > 0 .and. len(digits) < 5 .and. &
               verify(digits, '0123456789') == 0
            if (.not. good) return
            places(i) = 0
            do j = 1, len(digits)
               places(i) = 10*places(i) + iachar(digits(j:j)) - iachar('0')
            end do
         end associate
         begin = begin + next
      end do
   end subroutine split

   !> A parameter whose entries are Chebyshev series.
   pure subroutine new_function(entries, series, bounds, start, structure, load, change, message)
      !> (3, m) Kind of each entry and its place, counted from 1.
      integer, intent(in) :: entries(:, :)
      !> (degree + 1, m) The coefficients.
      real(wp), intent(in) :: series(:, :)
      !> Bounds of the parameter, and its value at the start.
      real(wp), intent(in) :: bounds(2), start
      !> The structure at the start.
      type(structure_type), intent(in) :: structure
      !> Its load.
      type(load_type), intent(in) :: load
      !> The parameter.
      type(change_type), intent(out) :: change
      !> What is wrong with it; empty if nothing is.
      character(:), allocatable, intent(out) :: message
      real(wp) :: value
      integer :: most(3), i

      message = ''
      do i = 1, size(entries, 2)
         associate (n => size(structure%mass, 1), gaps => size(structure%openings))
            select case (entries(1, i))
            case (of_mass, of_damping, of_stiffness)
               most = [0, n, n]
            case (of_direction)
               most = [0, n, gaps]
            case (of_opening, of_restitution)
               most = [0, gaps, 0]
            case (of_frequency)
               most = 0
            case (of_cosine, of_sine)
               most = [0, n, size(load%sine, 2)]
            case (of_constant)
               most = [0, n, 0]
            case (of_law)
               most = [0, gaps, 3]
            case (of_wall_cosine, of_wall_sine)
               most = [0, gaps, size(structure%motion, 1)]
            case default
               message = 'kinds are 1 to 13'
               return
            end select
         end associate
         if (any(entries(2:, i) < merge(1, 0, most(2:) > 0)) .or. any(entries(2:, i) > most(2:))) &
            then
            message = 'there is no entry of kind '//whole(entries(1, i))//' at '// &
               whole(entries(2, i))//', '//whole(entries(3, i))
            return
         end if
         if (any(entries(1, i) == [of_restitution, of_law])) then
            if ((structure%laws(entries(2, i))%kind > table_law) .neqv. entries(1, i) == of_law) &
               then
               message = 'a stop and friction have kind 11 in place of 6'
               return
            end if
            if (structure%laws(entries(2, i))%kind == table_law) then
               message = 'the restitution of gap '//whole(entries(2, i) - 1)//' is a table'
               return
            end if
         end if
      end do
      change%entries = entries
      allocate (change%series(0:size(series, 1) - 1, size(series, 2)))
      change%series(0:, :) = series
      change%chebyshev = .true.
      change%low = bounds(1)
      change%high = bounds(2)
      change%start = start
      do i = 1, size(entries, 2)
         value = entry_at(change, change%series(:, i), (start - bounds(1))/(bounds(2) - bounds(1)))
         if (abs(value - get(structure, load, entries(:, i))) <= 1.0e-6_wp*maxval(abs( &
            series(:, i)))) cycle
         message = 'the series of entry '//whole(i)//' is '//trim(number_text(value, .false., 10)) &
            //' at the motion, which has '//trim(number_text(get(structure, load, entries(:, i)), &
            .false., 10))
         return
      end do
   end subroutine new_function

   !> Whether the mirror image -q(t + T/2) of every motion q(t) is a motion too, with odd numbers of
   !! load cycles in T: gaps come in opposite pairs with the same opening and law, whose walls move
   !! half a load cycle apart, and the load has odd harmonics alone.
   pure logical function is_odd(path, friction) result(odd)
      !> The path; it is examined at two places.
      type(structure_path_type), intent(in) :: path
      !> Whether friction without a belt counts as its own image; false by default.
      logical, intent(in), optional :: friction
      type(structure_type) :: structure
      type(load_type) :: load
      real(wp), parameter :: shares(2) = [0.23_wp, 0.81_wp]
      integer :: h, i, k
      logical :: own

      own = .false.
      if (present(friction)) own = friction
      odd = .true.
      do k = 1, size(shares)
         call changed(path, spread(shares(k), 1, size(path%changes)), structure, load)
         odd = odd .and. .not. any(abs(load%constant) > 0)
         do h = 2, size(load%sine, 2), 2
            odd = odd .and. .not. any(abs(load%sine(:, h)) + abs(load%cosine(:, h)) > 0)
         end do
         do i = 1, size(structure%openings)
            if (own) then
               odd = odd .and. mirror_of(structure, i) > 0
            else
               odd = odd .and. opposite_gap(structure, i) > 0
            end if
         end do
      end do
   end function is_odd

   !> The image of a gap, a stop or friction, as of `is_odd`; 0 if there is none. That of friction
   !! on a belt has the opposite direction, so that its belt moves in the opposite sense.
   pure integer function mirror_of(structure, i) result(image)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The element.
      integer, intent(in) :: i

      associate (law => structure%laws(i))
         image = i
         if (law%kind /= friction_law .or. abs(law%numbers(3)) > 0) image = opposite_gap( &
            structure, i)
      end associate
   end function mirror_of

   !> The last gap of opposite direction with the same opening and law as a given one; 0 if there is
   !! none.
   pure integer function opposite_gap(structure, i) result(j)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> The gap.
      integer, intent(in) :: i

      do j = size(structure%openings), 1, -1
         if (any(abs(structure%directions(:, i) + structure%directions(:, j)) > 0)) cycle
         if (abs(structure%openings(i) - structure%openings(j)) > 0) cycle
         if (same_law(structure, i, j) .and. moves_alike(structure, i, j, -1)) return
      end do
   end function opposite_gap

   !> Whether the walls of two gaps move alike, or one half a load cycle, or an odd number of them,
   !! after the other.
   pure logical function moves_alike(structure, i, j, turn) result(alike)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Two gaps.
      integer, intent(in) :: i, j
      !> 1 for alike, -1 for half a cycle apart.
      integer, intent(in) :: turn
      !> Differences that are rounding, over the size of the motion.
      real(wp), parameter :: rounding = 1.0e-12_wp
      integer :: h

      alike = all([(abs(structure%motion(h, i) - turn**h*structure%motion(h, j)) <= &
         rounding*abs(structure%motion(h, i)), h=1, size(structure%motion, 1))])
   end function moves_alike

   !> Whether two gaps have the same law of restitution.
   pure logical function same_law(structure, i, j) result(same)
      !> The structure.
      type(structure_type), intent(in) :: structure
      !> Two gaps.
      integer, intent(in) :: i, j

      associate (a => structure%laws(i), b => structure%laws(j))
         same = a%kind == b%kind .and. .not. any(abs(a%numbers - b%numbers) > 0)
         if (.not. same .or. a%kind /= table_law) return
         same = size(a%speeds) == size(b%speeds)
         if (same) same = .not. any(abs(a%speeds - b%speeds) + abs(a%values - b%values) > 0)
      end associate
   end function same_law

end module vi_structure_path
