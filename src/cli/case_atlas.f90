!> The case of an &atlas group, checked.
module vi_case_atlas
   !$ use omp_lib, only: omp_get_max_threads
   use vi_atlas, only: atlas_request_type
   use vi_case_type, only: case_type
   use vi_case_zone, only: check_window
   use vi_keys, only: complain
   use vi_namelist, only: group_type
   use vi_raw, only: raw_type
   implicit none (type, external)
   private

   public :: take_atlas

contains

   !> Checks the variables of &atlas and puts them into a case.
   subroutine take_atlas(group, raw, case, line, message)
      type(group_type), intent(in) :: group
      type(raw_type), intent(in) :: raw
      type(case_type), intent(inout) :: case
      integer, intent(inout) :: line
      character(:), allocatable, intent(inout) :: message
      integer :: threads

      threads = 1
      !$ threads = omp_get_max_threads()
      associate (atlas => raw%atlas, zone => case%zone)
         zone%r = [atlas%r_min, atlas%r_max]
         zone%clearance = [atlas%clearance_min, atlas%clearance_max]
         zone%lines = atlas%lines
         zone%guesses = atlas%guesses
         zone%points = atlas%max_points
         case%atlas = atlas_request_type(case%osc, zone%r, zone%clearance, atlas%max_impacts, &
            atlas%max_cycles, atlas%survey, atlas%settling, zone%lines, zone%guesses, &
            zone%points, threads)
         if (atlas%max_impacts < 2 .or. atlas%max_impacts > 8) then
            call complain(group, 'max_impacts', line, message)
         else if (atlas%max_cycles < 1 .or. atlas%max_cycles > 4) then
            call complain(group, 'max_cycles', line, message)
         else if (atlas%survey < 0 .or. atlas%survey > 1000000) then
            call complain(group, 'survey', line, message)
         else if (atlas%settling < 1 .or. atlas%settling > 1000000) then
            call complain(group, 'settling', line, message)
         else
            call check_window(group, case, line, message)
         end if
      end associate
   end subroutine take_atlas

end module vi_case_atlas
