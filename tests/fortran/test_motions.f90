!> Tests of motions: linear problem, equispaced pair, stability, verdicts, time histories.
program test_motions
   use checks, only: finish
   use motions_assess, only: test_assess
   use motions_characteristic, only: test_characteristic
   use motions_equispaced, only: test_equispaced
   use motions_lanes, only: test_lanes
   use motions_linear, only: test_linear
   use motions_maps, only: test_maps
   use motions_orbit, only: test_orbits
   implicit none (type, external)

   call test_linear()
   call test_equispaced()
   call test_maps()
   call test_assess()
   call test_orbits()
   call test_characteristic()
   call test_lanes()
   call finish()

end program test_motions
