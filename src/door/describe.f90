!> The language of namelists, described from the tables of keys: for users and for programs.
module vi_describe
   use vi_case, only: output_keys, system_keys
   use vi_key, only: a_whole, a_word, describe_key, every_model, is_for, key_type, of_oscillator, &
      of_structure, unbounded
   use vi_kinds, only: wp
   use vi_result, only: column_kinds, column_type
   use vi_study, only: name_length, study_type
   use vi_structure_groups, only: friction_keys, gap_keys, load_keys, &
      matrix_keys => structure_keys, stop_keys
   use vi_study_list, only: find_study, list_studies
   use vi_sweep, only: sweep_keys
   use vi_text, only: append, line_type, number_text, whole
   implicit none (type, external)
   private

   public :: describe_all, describe_group, list_groups

   !> The names of the models, from `every_model` on.
   character(10), parameter :: models(0:2) = [character(10) :: '', 'oscillator', 'structure']

contains

   !> All groups of the language.
   subroutine list_groups(names)
      !> Their names.
      character(name_length), allocatable, intent(out) :: names(:)
      type(study_type), allocatable :: studies(:)

      call list_studies(studies)
      names = [character(name_length) :: 'system', 'structure', 'gap', 'stop', 'friction', &
         'load', studies%name, 'sweep', 'output']
   end subroutine list_groups

   !> The keys of a group for users: name, values, default, meaning.
   subroutine describe_group(name, lines)
      !> One of `list_groups`.
      character(*), intent(in) :: name
      !> The text.
      type(line_type), allocatable, intent(out) :: lines(:)
      type(study_type), allocatable :: studies(:)
      integer :: model, place, taken

      call list_studies(studies)
      taken = of_oscillator
      place = findloc(studies%name == name, .true., 1)
      if (place > 0) taken = studies(place)%models
      do model = of_oscillator, of_structure
         if (.not. is_for(taken, model)) cycle
         call append(lines, '&'//trim(name)//trim(merge(' of a &structure', repeat(' ', 16), &
            model == of_structure)))
         call describe_keys(name, model, lines)
      end do
   end subroutine describe_group

   !> Adds the keys of a group.
   subroutine describe_keys(name, model, lines)
      !> One of `list_groups`, and the model.
      character(*), intent(in) :: name
      integer, intent(in) :: model
      !> The text so far.
      type(line_type), allocatable, intent(inout) :: lines(:)
      type(key_type), allocatable :: keys(:)
      character(:), allocatable :: text
      integer :: i

      call keys_of(name, model, keys)
      do i = 1, size(keys)
         call describe_key(keys, i, text)
         call append(lines, '  '//trim(keys(i)%name)//': '//text)
         text = trim(keys(i)%meaning)
         if (len_trim(keys(i)%unit) > 0) text = text//' ['//trim(keys(i)%unit)//']'
         if (len_trim(keys(i)%default) > 0) text = &
            text//'; '//trim(keys(i)%default)//' if it is left &
            &out'
         call append(lines, '      '//text)
      end do
   end subroutine describe_keys

   !> The keys of all groups and the columns of all results for programs, as JSON.
   subroutine describe_all(lines)
      !> An object with two members: `groups` holds a list of keys for each group; `results` holds,
      !! for each study, the models that it takes, its meaning, the table whose rows are those of
      !! the CSV, by the model, and a list of columns. Keys and columns have the model for which
      !! they are, if it is not every one.
      type(line_type), allocatable, intent(out) :: lines(:)
      type(column_type), allocatable :: columns(:)
      type(study_type), allocatable :: studies(:)
      character(name_length), allocatable :: names(:)
      character(:), allocatable :: text
      integer :: i, j

      call append(lines, '{"groups": {')
      call list_groups(names)
      do i = 1, size(names)
         call append(lines, quoted(names(i))//': [')
         call list_keys(trim(names(i)), lines)
         call append(lines, trim(merge('], ', ']  ', i < size(names))))
      end do
      call append(lines, '}, "results": {')
      call list_studies(studies)
      do i = 1, size(studies)
         associate (study => studies(i))
            text = ''
            do j = of_oscillator, of_structure
               if (.not. is_for(study%models, j)) cycle
               if (len(text) > 0) text = text//', '
               text = text//quoted(models(j))//': '//quoted(study%row(j))
            end do
            call append(lines, quoted(study%name)//': {"in_python": '//truth(study%in_python)// &
               ', "takes_r": '//truth(study%has_load .and. .not. study%finds_r)// &
               ', "meaning": '//quoted(study%meaning)//', "rows": {'//text//'}, "columns": [')
            call study%list(columns=columns)
            do j = 1, size(columns)
               call describe_column(columns(j), text)
               if (j < size(columns)) text = text//','
               call append(lines, text)
            end do
         end associate
         call append(lines, trim(merge(']}, ', ']}  ', i < size(studies))))
      end do
      call append(lines, '}}')
   end subroutine describe_all

   !> Adds the keys of a group as objects, each with its values as the cases of its model take them.
   subroutine list_keys(name, lines)
      !> One of `list_groups`.
      character(*), intent(in) :: name
      !> The text so far.
      type(line_type), allocatable, intent(inout) :: lines(:)
      type(key_type), allocatable :: keys(:), oscillator_keys(:), structure_keys(:)
      character(:), allocatable :: text
      integer :: places(2), i

      call keys_of(name, every_model, keys)
      call keys_of(name, of_oscillator, oscillator_keys)
      call keys_of(name, of_structure, structure_keys)
      places = 0
      do i = 1, size(keys)
         where (is_for(keys(i)%model, [of_oscillator, of_structure])) places = places + 1
         if (keys(i)%model == of_structure) then
            call describe_json(structure_keys, places(of_structure), text)
         else
            call describe_json(oscillator_keys, places(of_oscillator), text)
         end if
         if (i < size(keys)) text = text//','
         call append(lines, text)
      end do
   end subroutine list_keys

   !> One column as an object.
   pure subroutine describe_column(column, text)
      !> The column.
      type(column_type), intent(in) :: column
      !> The object.
      character(:), allocatable, intent(out) :: text

      text = '  {"table": '//quoted(column%table)//', "name": '//quoted(column%name)// &
         ', "kind": '//quoted(column_kinds(column%kind))//', "each": '//quoted(column%each)// &
         ', "unit": '//quoted(column%unit)//', "meaning": '//quoted(column%meaning)// &
         ', "words": '//quoted(column%words)//', "listed": '//truth(column%listed)// &
         ', "label": '//quoted(column%label)//', "model": '//quoted(models(column%model))//'}'
   end subroutine describe_column

   !> One key as an object.
   pure subroutine describe_json(keys, place, text)
      !> The table of its group.
      type(key_type), intent(in) :: keys(:)
      !> Place of the key in its table.
      integer, intent(in) :: place
      !> The object.
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: takes
      character(6), parameter :: kinds(3) = [character(6) :: 'number', 'whole', 'word']

      call describe_key(keys, place, takes)
      associate (key => keys(place))
         text = '  {"name": '//quoted(key%name)//', "kind": '//quoted(kinds(key%kind))// &
            ', "least": '//whole(key%least)//', "most": '//whole(key%most)
         if (key%kind /= a_word) text = text//', "low": '//trim(bound(key%low, key))// &
            ', "high": '//trim(bound(key%high, key))//', "above": '//truth(key%above)// &
            ', "below": '//truth(key%below)
         text = &
            text//', "may_miss": '//truth(key%may_miss)//', "default": '//quoted(key%default)// &
            ', "words": '//quoted(key%words)//', "takes": '//quoted(takes)//', "or": '// &
            quoted(key%or)//', "over": '//quoted(key%over)//', "only": '//quoted(key%only)// &
            ', "never": '//quoted(key%never)//', "is": '//quoted(key%is)//', "option": '// &
            quoted(key%option)//', "unit": '//quoted(key%unit)//', "meaning": '// &
            quoted(key%meaning)//', "model": '//quoted(models(key%model))//'}'
      end associate
   end subroutine describe_json

   !> The keys of a group in cases of a model, or of all models.
   subroutine keys_of(name, model, keys)
      !> One of `list_groups`, and the model.
      character(*), intent(in) :: name
      integer, intent(in) :: model
      !> Its table.
      type(key_type), allocatable, intent(out) :: keys(:)
      type(study_type) :: study

      select case (name)
      case ('system')
         keys = system_keys
      case ('structure')
         keys = matrix_keys
      case ('gap')
         keys = gap_keys
      case ('stop')
         keys = stop_keys
      case ('friction')
         keys = friction_keys
      case ('load')
         keys = load_keys
      case ('sweep')
         keys = sweep_keys
      case ('output')
         keys = output_keys
      case default
         call find_study(name, study)
         if (model == every_model) call study%list(keys=keys)
         if (model /= every_model) call study%keys_of(model, keys)
      end select
   end subroutine keys_of

   !> A text as a JSON string; no text of the tables holds a double quote or a backslash.
   pure function quoted(text) result(string)
      !> A text; trailing blanks are left out.
      character(*), intent(in) :: text
      character(len_trim(text) + 2) :: string

      string = '"'//trim(text)//'"'
   end function quoted

   !> An end of a range, with trailing blanks; null if there is none.
   pure function bound(value, key) result(text)
      !> The end.
      real(wp), intent(in) :: value
      !> The key of this range.
      type(key_type), intent(in) :: key
      character(24) :: text

      text = 'null'
      if (abs(value) < unbounded) text = number_text(value, key%kind == a_whole)
   end function bound

   !> A logical value in JSON.
   pure function truth(value) result(word)
      !> A logical value.
      logical, intent(in) :: value
      character(merge(4, 5, value)) :: word

      word = merge('true ', 'false', value)
   end function truth

end module vi_describe
