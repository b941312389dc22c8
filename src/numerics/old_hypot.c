/* The hypot of the first glibc of this processor, for a wheel: of what the library needs, only this one has a newer
   version (2.35), which differs in how errors are told. The linker calls these in place of hypot and hypotf. */
#if defined(__x86_64__)
#define FIRST "GLIBC_2.2.5"
#elif defined(__aarch64__)
#define FIRST "GLIBC_2.17"
#else
#error "oldest_glibc: the first glibc of this processor is not known here"
#endif

double vi_first_hypot(double x, double y);
float vi_first_hypotf(float x, float y);
__asm__(".symver vi_first_hypot, hypot@" FIRST);
__asm__(".symver vi_first_hypotf, hypotf@" FIRST);

double __wrap_hypot(double x, double y);
float __wrap_hypotf(float x, float y);

double __wrap_hypot(double x, double y) { return vi_first_hypot(x, y); }
float __wrap_hypotf(float x, float y) { return vi_first_hypotf(x, y); }
