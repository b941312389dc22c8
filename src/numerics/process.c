/* What the process that runs the core allows: threads, stack space, memory. Fortran cannot query any of these.

   A child of fork() has none of its parent's threads, but OpenMP does not know that and would wait for them
   forever. In such a child each computation uses one thread. */
#if !defined(_WIN32)
#define _GNU_SOURCE
#include <ctype.h>
#include <limits.h>
#include <pthread.h>
#endif
#include <stdint.h>
#include <stdlib.h>

/* Bytes of stack that a computation may take; the largest use observed is half of this. */
static const size_t enough = 512 * 1024;

/* Whether this many bytes can be allocated now: 1 or 0. They are freed again. */
int vibroimpact_has_memory(double bytes)
{
    if (bytes >= (double)(SIZE_MAX / 4))
        return 0;
    void *volatile block = malloc((size_t)bytes);
    int there = block != NULL;
    free(block);
    return there;
}

#if defined(_WIN32)

int vibroimpact_thread_limit(void)
{
    return 1 << 20;
}

double vibroimpact_stack_size(void)
{
    return 1e9;
}

#else

static volatile int forked = 0;

static void note_fork(void)
{
    forked = 1;
}

__attribute__((constructor)) static void watch_forks(void)
{
    pthread_atfork(NULL, NULL, note_fork);
}

/* Bytes that OMP_STACKSIZE or GOMP_STACKSIZE gives to each OpenMP thread; 0 if neither is set. */
static size_t stack_of_environment(void)
{
    const char *names[] = {"OMP_STACKSIZE", "GOMP_STACKSIZE"};
    for (int i = 0; i < 2; i++) {
        const char *text = getenv(names[i]);
        if (text == NULL)
            continue;
        char *end;
        unsigned long long number = strtoull(text, &end, 10);
        if (end == text)
            continue;
        while (isspace((unsigned char)*end))
            end++;
        int unit = toupper((unsigned char)*end);
        int shift = unit == 'B' ? 0 : unit == 'M' ? 20 : unit == 'G' ? 30 : 10;
        return number > (SIZE_MAX >> shift) ? SIZE_MAX : (size_t)number << shift;
    }
    return 0;
}

/* The largest number of threads of a computation: 1 in a child of fork(), and where the stacks of the other threads
   would be too small. */
int vibroimpact_thread_limit(void)
{
    if (forked)
        return 1;
    size_t size = stack_of_environment();
    if (size == 0) {
        pthread_attr_t attributes;
        if (pthread_attr_init(&attributes) != 0)
            return 1;
        pthread_attr_getstacksize(&attributes, &size);
        pthread_attr_destroy(&attributes);
    }
    if (size > (size_t)1 << 26 && !vibroimpact_has_memory((double)size))
        return 1;
    return size < enough ? 1 : INT_MAX;
}

/* Bytes left on the stack of this thread; a large number if that is not known. */
double vibroimpact_stack_size(void)
{
    double left = 1e9;
#if defined(__GLIBC__)
    pthread_attr_t attributes;
    void *lowest;
    size_t size;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0)
        return left;
    if (pthread_attr_getstack(&attributes, &lowest, &size) == 0)
        left = (double)((char *)&size - (char *)lowest);
    pthread_attr_destroy(&attributes);
#elif defined(__APPLE__)
    char *highest = pthread_get_stackaddr_np(pthread_self());
    left = (double)pthread_get_stacksize_np(pthread_self()) - (double)(highest - (char *)&left);
#endif
    return left;
}

#endif

/* Bytes of stack that a computation needs on the thread that starts it. */
double vibroimpact_stack_needed(void)
{
    return (double)enough;
}
