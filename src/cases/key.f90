!> A key of a namelist group: which values it takes, how it depends on other keys, and what it
!! means.
!!
!! The keys of a group are in one constant table. The reader, its checks and messages, the echo in
!! the header of a result and the description of the language all use this table.
module vi_key
   use vi_kinds, only: wp
   use vi_text, only: number_text
   implicit none (type, external)
   private

   public :: describe_key, is_for, list_keys, place_of

   !> Kinds of values.
   integer, parameter, public :: a_number = 1, a_whole = 2, a_word = 3
   !> The models of systems: &system, and &structure with its gaps and its load. What is declared
   !! for `every_model` belongs to both.
   integer, parameter, public :: every_model = 0, of_oscillator = 1, of_structure = 2
   !> Units that depend on other keys: on `parameter`, on `target`, on the two `axes` of a plane of
   !! states, or on one of them, on the place in a state, and on `unit_names`.
   character(20), parameter, public :: of_parameter = 'units of parameter', &
      of_axes = 'units of axes', of_axis(2) = [character(20) :: 'units of first axis', &
      'units of second axis'], of_state = 'units of a state', of_names = 'unit_names', &
      of_target = 'units of target'
   !> No bound on one side.
   real(wp), parameter, public :: unbounded = huge(1.0_wp)
   !> Largest number of characters of a description of the values of a key.
   integer, parameter :: longest = 400

   type, public :: key_type
      !> Name as written in a file, in lower case.
      character(24) :: name = ''
      integer :: kind = a_number
      !> Smallest and largest number of values in its list.
      integer :: least = 1, most = 1
      !> The default as a user writes it; empty if there is none: the key must then be given, unless
      !! it `may_miss` or another key is given instead.
      character(40) :: default = ''
      logical :: may_miss = .false.
      !> The range of a number, or of each number in a list; `above` and `below` exclude its ends.
      real(wp) :: low = -unbounded, high = unbounded
      logical :: above = .false., below = .false.
      !> The words that it accepts, separated by blanks; empty if the study checks the word.
      character(80) :: words = ''
      !> Description of its values, if kind, range and words are not enough.
      character(longest) :: takes = ''
      !> Another key that may be given instead, but not together with it.
      character(24) :: or = ''
      !> A key whose value must be below this one's.
      character(24) :: over = ''
      !> A key, or 'key=word', without which this key must be left out; and keys, separated by
      !! blanks, together with which it must be left out.
      character(32) :: only = '', never = ''
      !> Text that is added to the message on these two, or, after an =, that replaces it.
      character(80) :: why = ''
      !> The key that this one specifies in another unit: values are multiplied by `factor`.
      character(24) :: is = ''
      real(wp) :: factor = 1
      !> Whether its words are paths of files; those of the folder of the namelist come first.
      logical :: file = .false.
      !> The command-line option for it, if its name differs from that of the key; an option that
      !! several keys share takes one value for each. A dash means that there is none.
      character(16) :: option = ''
      !> Its unit, and what it means. The unit of a frequency ratio is omega; some units depend on
      !! the values of other keys, see below.
      character(20) :: unit = ''
      character(160) :: meaning = ''
      !> The model whose cases have it. A key that differs for both is declared twice.
      integer :: model = every_model
   end type key_type

contains

   !> Whether what is declared for a model, or for every one, is for cases of a model.
   elemental logical function is_for(declared, model)
      !> `every_model` or a model.
      integer, intent(in) :: declared
      !> A model.
      integer, intent(in) :: model

      is_for = declared == every_model .or. declared == model
   end function is_for

   !> Adds keys for a model to a list.
   pure subroutine list_keys(model, keys, list)
      !> `every_model` or a model.
      integer, intent(in) :: model
      !> The keys.
      type(key_type), intent(in) :: keys(:)
      !> In and out: the list; it need not be allocated.
      type(key_type), allocatable, intent(inout) :: list(:)
      type(key_type), allocatable :: longer(:)
      integer :: n

      n = 0
      if (allocated(list)) n = size(list)
      allocate (longer(n + size(keys)))
      if (n > 0) longer(:n) = list
      longer(n + 1:) = keys
      if (model /= every_model) longer(n + 1:)%model = model
      call move_alloc(longer, list)
   end subroutine list_keys

   !> Place of a key in a table; 0 if there is no key of this name.
   pure integer function place_of(keys, name) result(place)
      !> The table.
      type(key_type), intent(in) :: keys(:)
      !> Name of the key, in lower case.
      character(*), intent(in) :: name

      do place = size(keys), 1, -1
         if (keys(place)%name == name) return
      end do
   end function place_of

   !> Describes the values that a key takes: 'a number with 0 <= xi < 1'.
   pure subroutine describe_key(keys, place, text)
      !> The table of its group.
      type(key_type), intent(in) :: keys(:)
      !> Place of the key in its table.
      integer, intent(in) :: place
      !> The text that follows 'must be' in a message.
      character(:), allocatable, intent(out) :: text
      integer :: i

      associate (key => keys(place))
         if (len_trim(key%takes) > 0) then
            text = trim(key%takes)
         else if (key%kind == a_word) then
            call list_words(key%words, text)
         else
            call describe_range(key, text)
         end if
         if (len_trim(key%over) > 0) text = &
            text//', and '//trim(key%over)//' below '//trim(key%name)
         do i = 1, size(keys)
            if (keys(i)%over == key%name) text = text//', and '//trim(key%name)//' below '// &
               trim(keys(i)%name)
         end do
      end associate
   end subroutine describe_key

   !> The range of a number.
   pure subroutine describe_range(key, text)
      !> The key.
      type(key_type), intent(in) :: key
      !> Its range in words.
      character(:), allocatable, intent(out) :: text

      text = 'a number'
      if (key%kind == a_whole) text = 'a whole number'
      if (key%high >= unbounded .and. key%low <= -unbounded) then
         text = 'a finite number'
         return
      end if
      text = text//' with '//trim(number_text(key%low, key%kind == &
         a_whole))//trim(merge(' < ', ' <=', key%above))//' '// &
         trim(key%name)
      if (key%high < unbounded) text = text//' '//trim(merge('< ', '<=', key%below))//' '// &
         trim(number_text(key%high, key%kind == a_whole))
   end subroutine describe_range

   !> Words in quotes: 'linear' or 'geometric'.
   pure subroutine list_words(words, text)
      !> Words separated by blanks.
      character(*), intent(in) :: words
      !> The words, separated by commas, with 'or' before the last one.
      character(:), allocatable, intent(out) :: text
      integer :: first, last

      text = ''
      last = 0
      do while (last < len_trim(words))
         first = last + 1
         last = first + index(words(first:)//' ', ' ') - 2
         if (len(text) > 0) text = text//trim(merge(' or', ',  ', last >= len_trim(words)))//' '
         text = text//''''//words(first:last)//''''
         last = last + 1
      end do
   end subroutine list_words

end module vi_key
