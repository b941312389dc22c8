/* Whether this processor runs what was compiled for wide registers (see meson.build): AVX2. */
int vibroimpact_runs_wide(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    return __builtin_cpu_supports("avx2") != 0;
#else
    return 0;
#endif
}
