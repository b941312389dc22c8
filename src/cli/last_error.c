/* Why the last call of the C library failed, as text of at most `capacity` bytes with its terminating null. Fortran
   cannot read errno, which is a macro. */
#define _POSIX_C_SOURCE 200112L
#include <errno.h>
#include <string.h>

void vibroimpact_last_error(char *text, size_t capacity)
{
    int code = errno;
    if (strerror_r(code, text, capacity) != 0)
        strncpy(text, "unknown error", capacity);
}
