/* After this call a write beyond the file size limit of the shell (ulimit -f) is an error that is reported, and does
   not end the program. Systems without such a limit have no such signal. */
#include <signal.h>

void vibroimpact_ignore_size_signal(void)
{
#ifdef SIGXFSZ
    signal(SIGXFSZ, SIG_IGN);
#endif
}
