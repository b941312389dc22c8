!> The variables of &branch, &zone and &atlas, as the compiler's namelist input reads them.
module vi_raw_studies
   use vi_kinds, only: wp
   use vi_room, only: most_letters
   implicit none (type, external)
   private

   public :: blank_studies, read_atlas, read_branch, read_zone

   !> The keys of &branch.
   type, public :: raw_branch_type
      character(most_letters) :: parameter
      real(wp) :: low, high, longest_step
      integer :: max_points
   end type raw_branch_type

   !> The keys of &zone.
   type, public :: raw_zone_type
      character(most_letters) :: sides, symmetric
      real(wp) :: r_min, r_max, clearance_min, clearance_max
      integer :: cycles, lines, guesses, max_points
   end type raw_zone_type

   !> The keys of &atlas.
   type, public :: raw_atlas_type
      real(wp) :: r_min, r_max, clearance_min, clearance_max
      integer :: max_impacts, max_cycles, survey, settling, lines, guesses, max_points
   end type raw_atlas_type

contains

   !> Nothing given yet.
   subroutine blank_studies(not_given, branch, zone, atlas)
      !> The number that stands for one that was not given.
      real(wp), intent(in) :: not_given
      type(raw_branch_type), intent(out) :: branch
      type(raw_zone_type), intent(out) :: zone
      type(raw_atlas_type), intent(out) :: atlas

      branch = raw_branch_type('', not_given, not_given, 0.05_wp, 4000)
      zone = raw_zone_type('', 'both', not_given, not_given, not_given, not_given, 1, 17, 12, 20000)
      atlas = raw_atlas_type(not_given, not_given, not_given, not_given, 5, 1, 400, 400, 17, 24, &
         20000)
   end subroutine blank_studies

   !> One assignment of &branch.
   subroutine read_branch(text, raw, status)
      character(*), intent(in) :: text
      type(raw_branch_type), intent(inout) :: raw
      integer, intent(out) :: status
      character(most_letters) :: parameter
      real(wp) :: low, high, longest_step
      integer :: max_points
      namelist /branch/ parameter, low, high, longest_step, max_points

      parameter = raw%parameter
      low = raw%low
      high = raw%high
      longest_step = raw%longest_step
      max_points = raw%max_points
      read (text, nml=branch, iostat=status)
      raw = raw_branch_type(parameter, low, high, longest_step, max_points)
   end subroutine read_branch

   !> One assignment of &zone.
   subroutine read_zone(text, raw, status)
      character(*), intent(in) :: text
      type(raw_zone_type), intent(inout) :: raw
      integer, intent(out) :: status
      character(most_letters) :: sides, symmetric
      real(wp) :: r_min, r_max, clearance_min, clearance_max
      integer :: cycles, lines, guesses, max_points
      namelist /zone/ sides, cycles, symmetric, r_min, r_max, clearance_min, clearance_max, lines, &
         guesses, max_points

      sides = raw%sides
      symmetric = raw%symmetric
      r_min = raw%r_min
      r_max = raw%r_max
      clearance_min = raw%clearance_min
      clearance_max = raw%clearance_max
      cycles = raw%cycles
      lines = raw%lines
      guesses = raw%guesses
      max_points = raw%max_points
      read (text, nml=zone, iostat=status)
      raw = raw_zone_type(sides, symmetric, r_min, r_max, clearance_min, clearance_max, cycles, &
         lines, guesses, max_points)
   end subroutine read_zone

   !> One assignment of &atlas.
   subroutine read_atlas(text, raw, status)
      character(*), intent(in) :: text
      type(raw_atlas_type), intent(inout) :: raw
      integer, intent(out) :: status
      real(wp) :: r_min, r_max, clearance_min, clearance_max
      integer :: max_impacts, max_cycles, survey, settling, lines, guesses, max_points
      namelist /atlas/ r_min, r_max, clearance_min, clearance_max, max_impacts, max_cycles, &
         survey, settling, lines, guesses, max_points

      r_min = raw%r_min
      r_max = raw%r_max
      clearance_min = raw%clearance_min
      clearance_max = raw%clearance_max
      max_impacts = raw%max_impacts
      max_cycles = raw%max_cycles
      survey = raw%survey
      settling = raw%settling
      lines = raw%lines
      guesses = raw%guesses
      max_points = raw%max_points
      read (text, nml=atlas, iostat=status)
      raw = raw_atlas_type(r_min, r_max, clearance_min, clearance_max, max_impacts, max_cycles, &
         survey, settling, lines, guesses, max_points)
   end subroutine read_atlas

end module vi_raw_studies
