/* Counts how often each block is reached of a program compiled with -fsanitize-coverage=trace-pc, such as the
 * build build/switched/counted (switched.py). */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BLOCKS (1u << 24)

uint32_t reached[BLOCKS];
uintptr_t first_address;

/* The origin of addresses. */
void count_from(uintptr_t address)
{
    first_address = address;
    memset(reached, 0, sizeof reached);
}

/* Called by the compiled code at the beginning of each block. */
void __sanitizer_cov_trace_pc(void)
{
    uintptr_t place = (uintptr_t)__builtin_return_address(0) - first_address;
    if (first_address != 0 && place < BLOCKS)
        reached[place]++;
}

/* At its end a process writes what it reached into a folder, if there is one: the file is named after the process
 * and the program or library. */
__attribute__((destructor)) static void write_reached(void)
{
    const char *folder = getenv("VIBROIMPACT_REACHED");
    char name[4096];
    Dl_info about;
    if (folder == NULL || first_address == 0 || dladdr((void *)first_address, &about) == 0)
        return;
    snprintf(name, sizeof name, "%s/%d.%s", folder, (int)getpid(), basename(about.dli_fname));
    FILE *file = fopen(name, "wb");
    if (file == NULL)
        return;
    for (uint32_t place = 0; place < BLOCKS; place++)
        if (reached[place] != 0)
            fwrite(&place, sizeof place, 1, file);
    fclose(file);
}
