!> The group &sweep after that of a study: keys of the case that take many values. Such a case is a
!! campaign, which the Python package runs.
module vi_sweep
   use vi_key, only: a_whole, a_word, key_type
   use vi_kinds, only: wp
   implicit none (type, external)
   private

   type(key_type), parameter, public :: sweep_keys(*) = [ &
      key_type('keys', a_word, most=20, &
      takes='names of keys of the case, such as ''xi'', or with their group, ''system.xi''', &
      meaning='the keys that take many values'), &
      key_type('values', most=1000000, never='words low samples', may_miss=.true., &
      meaning='all values, those of the first key first'), &
      key_type('words', a_word, most=100000, never='low samples', &
      may_miss=.true., takes='texts', meaning='all values of keys that take texts'), &
      key_type('counts', a_whole, most=20, low=1.0_wp, high=1.0e9_wp, never='samples', &
      may_miss=.true., meaning='number of values of each key; the cases are all their &
      &combinations'), &
      key_type('low', most=20, may_miss=.true., meaning='lowest value of each key'), &
      key_type('high', most=20, only='low', may_miss=.true., meaning='largest value of each key'), &
      key_type('spacing', a_word, most=20, words='linear geometric', only='low', &
      may_miss=.true., meaning='spacing of the values of each key; linear by default'), &
      key_type('samples', a_whole, low=1.0_wp, high=1.0e9_wp, only='low', may_miss=.true., &
      meaning='number of points in the box between low and high, instead of a grid'), &
      key_type('method', a_word, words='sobol latin_hypercube', only='samples', may_miss=.true., &
      meaning='how these points are chosen; sobol by default'), &
      key_type('seed', a_whole, low=0.0_wp, high=2147483647.0_wp, only='samples', &
      may_miss=.true., meaning='seed of these points; 0 by default')]

end module vi_sweep
