/* Counts how often each block of a program is reached that was compiled with -fsanitize-coverage=trace-pc.
 *
 * The library for C that counts, for find_answers.py:
 *
 *     mkdir -p build/reached
 *     gcc -O2 -shared -fPIC -o build/reached/libreached.so tests/quality/reached.c
 *     meson setup build/counted -Dpython=disabled -Dlibrary_for_c=enabled -Doptimization=1 -Db_lundef=false \
 *       -Dfortran_args=-fsanitize-coverage=trace-pc \
 *       -Dfortran_link_args="-L$PWD/build/reached -lreached -Wl,-rpath,$PWD/build/reached"
 *     ninja -C build/counted
 *     python tests/quality/find_answers.py --search build/counted/src/c/libvibroimpact.so */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { BLOCKS = 1 << 24 };

uint32_t reached[BLOCKS];
uintptr_t first_address;

/* Where addresses are counted from. */
void count_from(uintptr_t address)
{
    first_address = address;
    memset(reached, 0, sizeof reached);
}

/* What the compiler calls at the begin of each block. */
void __sanitizer_cov_trace_pc(void)
{
    uintptr_t place = (uintptr_t)__builtin_return_address(0) - first_address;
    if (first_address != 0 && place < BLOCKS)
        reached[place]++;
}
