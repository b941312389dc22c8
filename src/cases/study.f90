!> The declaration of a study: its meaning, its keys and columns, and the procedures that check and
!! run its cases.
!!
!! Each study provides one; `vi_study_list` collects them, and all other code finds them there. A
!! study needs no other module of this folder, except for texts.
module vi_study
   use vi_case, only: case_type
   use vi_key, only: a_whole, a_word, every_model, is_for, key_type, list_keys, of_axes, of_axis, &
      of_oscillator, of_parameter, of_state, of_structure, of_target
   use vi_kinds, only: wp
   use vi_result, only: column_type, complexes, list_columns, result_type, truths, verdicts, &
      wholes, words
   use vi_values, only: values_type
   implicit none (type, external)
   private

   public :: join_groups, list_for, place_of_study

   !> What a study needs to declare keys and columns, read a case, and fill a result.
   public :: a_whole, a_word, case_type, column_type, complexes, every_model, key_type, of_axes, &
      of_axis, of_oscillator, of_parameter, of_state, of_structure, of_target, result_type, &
      truths, values_type, verdicts, wholes, words

   !> Largest number of characters of the name of a study.
   integer, parameter, public :: name_length = 11

   !> The declaration of a study.
   type, public :: study_type
      !> Its name, which no other study has, and that of the group that requests it.
      character(name_length) :: name = ''
      !> The models that it takes.
      integer :: models = every_model
      !> What it does, as a request: 'find the zones ...'.
      character(72) :: meaning = ''
      !> Whether its structures may have stops and friction.
      logical :: takes_elements = .false.
      !> Whether walls of its structures may move.
      logical :: takes_walls = .false.
      !> Whether there is a load; without one there is no frequency ratio.
      logical :: has_load = .true.
      !> Whether the frequency ratio is a part of its result; &system has none then.
      logical :: finds_r = .false.
      !> Whether its cases are computed by the Python package, which has libraries that the core
      !! has not. Keys, checks and columns are declared as of any other study; `run` stays null, and
      !! the core says who computes the case. In Python the class of the result (a `Noun`) has the
      !! class method `computed(case, progress)`, which takes the checked values from `case.keys`
      !! and `case.osc` and returns an object of the class, whose tables are those of
      !! `tables.made(study, case.text, tables, notes=...)` with the columns declared here.
      !! Commands, formats and pages need nothing else.
      logical :: in_python = .false.
      !> The group before it from which it starts, by the model; empty if there is none.
      character(name_length) :: starts_from(2) = ''
      !> Lists the keys of its group and the columns of its result, for all models.
      procedure(declare_interface), pointer, nopass :: list => null()
      !> The table whose rows are those of the CSV, by the model.
      character(16) :: row(2) = ''
      !> Checks what depends on several keys; null if nothing does.
      procedure(check_interface), pointer, nopass :: check => null()
      !> Checks the group that it starts from; null if there is none.
      procedure(check_start_interface), pointer, nopass :: check_start => null()
      !> Bytes of memory that a case needs, results included; null if they are few for all cases.
      procedure(memory_interface), pointer, nopass :: memory => null()
      procedure(run_interface), pointer, nopass :: run => null()
   contains
      procedure :: columns_of, keys_of
   end type study_type

   !> Adds keys or columns for a model to a list. One array constructor of all would need 50 kB of
   !! stack, and a thread can have 64.
   interface list_for
      procedure :: list_keys, list_columns
   end interface list_for

   !> A procedure that fills in a declaration, as an element of lists.
   type, public :: declare_type
      procedure(declare_interface), pointer, nopass :: declare => null()
   end type declare_type

   abstract interface
      !> Checks what depends on several keys.
      subroutine check_interface(case)
         import :: case_type
         implicit none (type, external)
         !> In: with its groups read. Out: complete, or with a fault in one of them.
         type(case_type), intent(inout) :: case
      end subroutine check_interface

      !> Checks the group that a study starts from.
      subroutine check_start_interface(case, line)
         import :: case_type
         implicit none (type, external)
         !> In: with its `start` read. Out: with it complete, or with a fault in it.
         type(case_type), intent(inout) :: case
         !> Line of the group of the study.
         integer, intent(in) :: line
      end subroutine check_start_interface

      !> An upper estimate of the memory that a case takes. A failed allocation would end the
      !! program, so the estimate is checked before the study starts.
      pure real(wp) function memory_interface(case)
         import :: case_type, wp
         implicit none (type, external)
         !> The case, checked.
         type(case_type), intent(in) :: case
      end function memory_interface

      !> Computes a case, and fills its result.
      subroutine run_interface(case, threads, result, progress)
         import :: case_type, result_type
         implicit none (type, external)
         !> The case, checked.
         type(case_type), intent(in) :: case
         !> Number of OpenMP threads; the result does not depend on it.
         integer, intent(in) :: threads
         !> In: started, without tables. Out: filled, with notes on what failed.
         type(result_type), intent(inout) :: result
         !> Progress counters, see vi_progress.
         integer, intent(inout), optional :: progress(3)
      end subroutine run_interface

      !> Declares a study. Its keys, in the order of the echo, and its columns, in that of the CSV,
      !! are not stored, since most callers need those of one study only.
      pure subroutine declare_interface(study, keys, columns)
         import :: column_type, key_type, study_type
         implicit none (type, external)
         !> The declaration, without `list`.
         type(study_type), intent(out), optional :: study
         !> The keys of the group, of all models.
         type(key_type), allocatable, intent(out), optional :: keys(:)
         !> The columns of the result, of all models.
         type(column_type), allocatable, intent(out), optional :: columns(:)
      end subroutine declare_interface
   end interface

contains

   !> The keys of its group in cases of a model.
   pure subroutine keys_of(study, model, keys)
      !> The study.
      class(study_type), intent(in) :: study
      !> The model.
      integer, intent(in) :: model
      !> Its keys, in the order of the echo.
      type(key_type), allocatable, intent(out) :: keys(:)
      type(key_type), allocatable :: listed(:)
      integer :: i

      call study%list(keys=listed)
      keys = listed(pack([(i, i=1, size(listed))], is_for(listed%model, model)))
   end subroutine keys_of

   !> The columns of its results for a model.
   pure subroutine columns_of(study, model, columns)
      !> The study.
      class(study_type), intent(in) :: study
      !> The model.
      integer, intent(in) :: model
      !> Its columns, in the order of the CSV.
      type(column_type), allocatable, intent(out) :: columns(:)
      type(column_type), allocatable :: listed(:)
      integer :: i

      call study%list(columns=listed)
      columns = listed(pack([(i, i=1, size(listed))], is_for(listed%model, model)))
   end subroutine columns_of

   !> Place of the study that a group requests; 0 if none does.
   pure integer function place_of_study(studies, group, model) result(place)
      !> All studies.
      type(study_type), intent(in) :: studies(:)
      !> Name of the group.
      character(*), intent(in) :: group
      !> The model of the system.
      integer, intent(in) :: model

      do place = size(studies), 1, -1
         if (studies(place)%name == group .and. is_for(studies(place)%models, model)) return
      end do
   end function place_of_study

   !> Names of groups for messages: '&motion, &simulate or &find'.
   pure subroutine join_groups(names, text)
      !> Names of groups; one that occurs twice is named once.
      character(*), intent(in) :: names(:)
      !> The names in a sentence; empty if there are none.
      character(:), allocatable, intent(out) :: text
      integer, allocatable :: places(:)
      integer :: i

      text = ''
      places = pack([(i, i=1, size(names))], [(.not. any(names(:i - 1) == names(i)), &
         i=1, size(names))])
      do i = 1, size(places)
         if (i > 1) text = text//trim(merge(' or', ',  ', i == size(places)))//' '
         text = text//'&'//trim(names(places(i)))
      end do
   end subroutine join_groups

end module vi_study
