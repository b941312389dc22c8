!> The room that texts and lists of a namelist have.
module vi_room
   implicit none (type, external)
   private

   !> Impacts that a list of the namelist has room for.
   integer, parameter, public :: most_impacts = 1000
   !> Letters that a text of the namelist has room for; one longer is refused.
   integer, parameter, public :: most_letters = most_impacts + 1

end module vi_room
