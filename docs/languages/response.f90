! gfortran response.f90 -o response $(pkg-config --libs vibroimpact)
program response
   use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_int, c_int32_t, &
      c_int64_t, c_null_char, c_null_ptr, c_ptr
   implicit none (type, external)

   ! struct vibroimpact_column of vibroimpact.h
   type, bind(c) :: column_type
      character(kind=c_char) :: table(17), name(25), each(17), unit(17), label(29), meaning(161)
      integer(c_int32_t) :: kind, listed, place, table_place, n_dims, shape(4), n_words
      type(c_ptr) :: x, k
   end type column_type

   interface
      integer(c_int) function vibroimpact_run(text, threads, tally, result) bind(c)
         import
         character(kind=c_char), intent(in) :: text(*)
         integer(c_int), value :: threads
         type(c_ptr), value :: tally
         integer(c_int64_t), intent(out) :: result
      end function vibroimpact_run
      integer(c_int) function vibroimpact_find(result, table, name, column) bind(c)
         import
         integer(c_int64_t), value :: result
         character(kind=c_char), intent(in) :: table(*), name(*)
         type(column_type), intent(out) :: column
      end function vibroimpact_find
      subroutine vibroimpact_free(result) bind(c)
         import
         integer(c_int64_t), value :: result
      end subroutine vibroimpact_free
   end interface

   character(*), parameter :: text = '&system xi = 0.0114, mu = 0.028, restitution = 0.75 /' &
      //new_line('a')//'&response r_min = 1.00, r_max = 1.04, r_points = 5, clearance = 25, &
      &states = 6 /'//c_null_char
   integer(c_int64_t) :: result
   real(c_double), pointer :: r(:), lowest(:), highest(:)
   integer :: i

   if (vibroimpact_run(text, 0_c_int, c_null_ptr, result) /= 0) error stop 'the case failed'
   call find('r', r)
   call find('lowest', lowest)
   call find('highest', highest)
   do i = 1, size(r)
      print '(f4.2,2(1x,f12.10))', r(i), lowest(i), highest(i)
   end do
   call vibroimpact_free(result)

contains

   subroutine find(name, values)
      character(*), intent(in) :: name
      real(c_double), pointer, intent(out) :: values(:)
      type(column_type) :: column

      if (vibroimpact_find(result, 'points'//c_null_char, name//c_null_char, column) /= 0) &
         error stop 'no such column'
      call c_f_pointer(column%x, values, [column%shape(1)])
   end subroutine find

end program response
