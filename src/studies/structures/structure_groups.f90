!> The groups of a structure: &structure, its gaps, stops and friction, and its load.
module vi_structure_groups
   use vi_case, only: case_type
   use vi_kinds, only: wp
   use vi_namelist, only: group_type
   use vi_structure, only: by_newton, in_sequence, load_type, new_structure, structure_type
   use vi_structure_gaps, only: check_gap, friction_keys, gap_keys, gaps_of, harmonics_of, &
      stop_keys
   use vi_structure_loads, only: check_load, complete_coordinates, complete_record, &
      load_frequency, load_keys, load_of, record_end, record_of
   use vi_structure_matrices, only: check_matrices, check_outputs, find_coordinates, &
      matrices_of, most_coordinates, output_rows, read_structure, structure_keys
   use vi_values, only: read_values, values_type
   implicit none (type, external)
   private

   public :: complete_coordinates, element_besides_gaps, friction_keys, gap_keys, has_moving_wall, &
      load_frequency, load_keys, most_coordinates, output_rows, read_parts, read_structure, &
      record_end, record_of, stop_keys, structure_keys, structure_of

contains

   !> Reads the gaps and the load of a structure, and checks all of them.
   subroutine read_parts(path, groups, structure, parts, coordinates)
      !> The file of the namelist; empty if there is none.
      character(*), intent(in) :: path
      !> The groups after &structure that belong to it.
      type(group_type), intent(in) :: groups(:)
      !> In: as read. Out: complete, or with a fault.
      type(values_type), intent(inout) :: structure
      !> Its gaps and stops, its friction and then its load, complete, or the first of them with a
      !! fault.
      type(values_type), allocatable, intent(out) :: parts(:)
      !> Number of coordinates.
      integer, intent(out) :: coordinates
      integer :: order(size(groups)), i, points
      integer :: place(size(groups))

      place = [(place_of_part(groups(i)%name), i=1, size(groups))]
      order = [(pack([(i, i=1, size(groups))], place == points), points=1, 3)]
      allocate (parts(size(groups)))
      do i = 1, size(groups)
         associate (group => groups(order(i)))
            if (group%name == 'gap') then
               call read_values('gap', gap_keys, group, parts(i))
            else if (group%name == 'stop') then
               call read_values('stop', stop_keys, group, parts(i))
            else if (group%name == 'friction') then
               call read_values('friction', friction_keys, group, parts(i))
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
      if (len(structure%fault) == 0) call check_outputs(structure, coordinates)
      if (len(structure%fault) > 0) return
      points = coordinates
      if (structure%has('frequencies')) points = size(structure%numbers('shapes'))/coordinates
      do i = 1, size(parts)
         if (parts(i)%name /= 'load') then
            call check_gap(parts(i), points)
            if (harmonics_of(parts(i)) > 0 .and. .not. has_frequency(parts)) call parts(i)%refuse( &
               trim(merge('cosine', 'sine  ', parts(i)%has('cosine'))), &
               'it requires a &load with a frequency')
         else
            call check_load(parts(i), coordinates)
            call complete_record(path, structure, coordinates, parts(i))
         end if
      end do
   end subroutine read_parts

   !> The place of a part of a structure: gaps and stops, friction, load.
   pure integer function place_of_part(name) result(place)
      !> The name of its group.
      character(*), intent(in) :: name

      place = 1
      if (name == 'friction') place = 2
      if (name == 'load') place = 3
   end function place_of_part

   !> The name of the first group of a structure that is an element other than a gap; empty if there
   !! is none.
   pure subroutine element_besides_gaps(case, name)
      !> A case with the structure.
      type(case_type), intent(in) :: case
      !> The name.
      character(:), allocatable, intent(out) :: name
      integer :: i

      name = ''
      do i = size(case%parts), 1, -1
         if (case%parts(i)%name == 'stop' .or. case%parts(i)%name == 'friction') name = &
            case%parts(i)%name
      end do
   end subroutine element_besides_gaps

   !> Whether a load among parts has a frequency.
   pure logical function has_frequency(parts)
      !> The parts.
      type(values_type), intent(in) :: parts(:)

      has_frequency = .false.
      if (size(parts) == 0) return
      associate (last => parts(size(parts)))
         if (last%name == 'load') has_frequency = last%has('frequency')
      end associate
   end function has_frequency

   !> Whether the wall of a gap or a stop of a case moves.
   pure logical function has_moving_wall(case)
      !> A case with the structure.
      type(case_type), intent(in) :: case
      integer :: i

      has_moving_wall = any([(harmonics_of(case%parts(i)) > 0, i=1, size(case%parts))])
   end function has_moving_wall

   !> The structure and the load of a case.
   pure subroutine structure_of(case, structure, load)
      !> A case with a structure.
      type(case_type), intent(in) :: case
      !> M, C, K and the gaps.
      type(structure_type), intent(out) :: structure
      !> The load; without harmonics its frequency is 0.
      type(load_type), intent(out) :: load
      real(wp) :: matrices(case%coordinates, case%coordinates, 3)
      real(wp), allocatable :: shapes(:, :), directions(:, :), gap_values(:, :)
      integer :: i, gaps

      gaps = count([(case%parts(i)%name /= 'load', i=1, size(case%parts))])
      associate (s => case%system, n => case%coordinates)
         call matrices_of(s, n, matrices)
         if (s%has('frequencies')) shapes = reshape(s%numbers('shapes'), &
            [n, size(s%numbers('shapes'))/n])
         call gaps_of(case%parts(:gaps), n, directions, gap_values, shapes)
      end associate
      structure = new_structure(matrices, directions, gap_values)
      if (case%system%has('simultaneous')) structure%simultaneous = merge(by_newton, in_sequence, &
         case%system%is('simultaneous', 'newton'))
      call load_of(case, load)
      if (structure%moves) load%frequency = load_frequency(case)
   end subroutine structure_of

end module vi_structure_groups
