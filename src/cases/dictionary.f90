!> A list of different texts, in which the time to find a text does not depend on their number.
module vi_dictionary
   use, intrinsic :: iso_fortran_env, only: int64
   use vi_text, only: lengthen, line_type
   implicit none (type, external)
   private

   public :: find_text, include_text

   type, public :: dictionary_type
      !> The texts in the order in which they were added, followed by unused entries.
      type(line_type), allocatable :: texts(:)
      !> Number of texts.
      integer :: n = 0
      !> The place of a text in the list, at its hash value or the next free slot; 0 in free slots.
      integer, allocatable, private :: slots(:)
   end type dictionary_type

contains

   !> Finds a text.
   pure subroutine find_text(dictionary, text, place)
      !> The list.
      type(dictionary_type), intent(in) :: dictionary
      !> The text; trailing blanks count.
      character(*), intent(in) :: text
      !> Its place in the list; 0 if it is not there.
      integer, intent(out) :: place

      place = 0
      if (allocated(dictionary%slots)) place = dictionary%slots(slot_of(dictionary, text))
   end subroutine find_text

   !> Finds a text, and adds it if it is not there.
   pure subroutine include_text(dictionary, text, place)
      !> In and out: the list.
      type(dictionary_type), intent(inout) :: dictionary
      !> The text; trailing blanks count.
      character(*), intent(in) :: text
      !> Its place in the list.
      integer, intent(out) :: place
      integer :: slot, i

      if (.not. allocated(dictionary%slots)) then
         allocate (dictionary%slots(32), source=0)
         if (allocated(dictionary%texts)) deallocate (dictionary%texts)
         allocate (dictionary%texts(16))
      end if
      slot = slot_of(dictionary, text)
      place = dictionary%slots(slot)
      if (place > 0) return
      if (dictionary%n == size(dictionary%texts)) then
         call lengthen(dictionary%texts, dictionary%n)
         deallocate (dictionary%slots)
         allocate (dictionary%slots(4*dictionary%n), source=0)
         do i = 1, dictionary%n
            dictionary%slots(slot_of(dictionary, dictionary%texts(i)%text)) = i
         end do
         slot = slot_of(dictionary, text)
      end if
      dictionary%n = dictionary%n + 1
      place = dictionary%n
      dictionary%texts(place)%text = text
      dictionary%slots(slot) = place
   end subroutine include_text

   !> The slot of a text, or the free slot for it.
   pure integer function slot_of(dictionary, text) result(slot)
      !> The list; at least half of its slots are free.
      type(dictionary_type), intent(in) :: dictionary
      !> The text.
      character(*), intent(in) :: text
      ! the Fowler-Noll-Vo hash function
      integer(int64), parameter :: start = 2166136261_int64, factor = 16777619_int64, &
         mask = 4294967295_int64
      integer(int64) :: hash
      integer :: i

      hash = start
      do i = 1, len(text)
         hash = iand(ieor(hash, int(iachar(text(i:i)), int64))*factor, mask)
      end do
      slot = 1 + int(modulo(hash, size(dictionary%slots, kind=int64)))
      do
         if (dictionary%slots(slot) == 0) return
         associate (known => dictionary%texts(dictionary%slots(slot))%text)
            if (len(known) == len(text)) then
               if (known == text) return
            end if
         end associate
         slot = 1 + modulo(slot, size(dictionary%slots))
      end do
   end function slot_of

end module vi_dictionary
