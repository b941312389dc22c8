/* Runs many namelists through the C interface, as vibroimpact_run does, and reports the outcome of each.
 *
 * usage: namelists FILE BUDGET BATCH
 *
 * FILE holds the namelists, each after its length (4 bytes). A child process runs BATCH of them (at most 500) one
 * after the other; if one crashes the child, the next child continues after it. BUDGET is the CPU time in
 * milliseconds after which a case is asked to stop; one that goes on for 20 seconds ends its child.
 *
 * For each namelist stdout gets its outcome, its CPU time in microseconds and the length of a text (4 bytes each),
 * and the text: the message of a namelist that is refused, the complete case of one that is accepted, or what is
 * wrong. A batch that leaks as a whole has a record of its own after those of its namelists. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <vibroimpact.h>

/* Outcomes above the status codes of vibroimpact.h. */
enum { BROKEN_LAW = 100, BREAKDOWN = 101, HANG = 102, LEAK = 103, LEAK_IN_BATCH = 104 };

/* Largest number of namelists that one child runs. */
enum { MOST = 500 };

/* Defined by the address sanitizer; null without it. */
extern int __lsan_do_recoverable_leak_check(void) __attribute__((weak));

static int32_t counters[3];
static volatile int ticks;
static double budget;
static FILE *in, *out;

static const char *law;

static void breach(const char *text)
{
    if (law == NULL)
        law = text;
}

#define CHECK(condition) \
    do { \
        if (!(condition)) \
            breach(#condition); \
    } while (0)

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

static void tick(int number)
{
    const char text[] = "\nthe case does not end\n";
    __atomic_store_n(&counters[2], 1, __ATOMIC_RELAXED);
    if (budget * ++ticks > 2e4 || number == SIGALRM) {
        if (write(2, text, sizeof text - 1) < 0)
            _exit(4);
        abort();
    }
}

/* The clock of one call: CPU time, and half an hour of waiting, since a busy machine may leave it little. */
static void set_clock(int on)
{
    struct itimerval each = {{0, 0}, {0, 0}}, wait = {{0, 0}, {0, 0}};
    if (on) {
        each.it_value.tv_sec = each.it_interval.tv_sec = (long)(budget / 1e3);
        each.it_value.tv_usec = each.it_interval.tv_usec = (long)(budget * 1e3) % 1000000;
        wait.it_value.tv_sec = 1800;
    }
    ticks = 0;
    setitimer(ITIMER_PROF, &each, NULL);
    setitimer(ITIMER_REAL, &wait, NULL);
}

static char *copy_text(vibroimpact_result result, int what)
{
    size_t n = vibroimpact_text(result, what, NULL, 0);
    char *text = malloc(n + 1);
    CHECK(vibroimpact_text(result, what, text, n + 1) == n);
    CHECK(strlen(text) == n);
    return text;
}

static uint64_t hash(uint64_t sum, const void *bytes, size_t n)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < n; i++)
        sum = (sum ^ byte[i]) * 1099511628211u;
    return sum;
}

/* A checksum of all values of a result. */
static uint64_t sum_of(vibroimpact_result result)
{
    struct vibroimpact_column column;
    uint64_t sum = 14695981039346656037u;
    memset(&column, 0, sizeof column);
    for (int i = 0; vibroimpact_column(result, i, &column) == 0; i++) {
        size_t n = 1;
        for (int j = 0; j < 4; j++) {
            CHECK(column.shape[j] >= 0);
            n *= (size_t)column.shape[j];
        }
        if (column.x != NULL)
            sum = hash(sum, column.x, n * (column.kind == VIBROIMPACT_COMPLEXES ? 16 : 8));
        if (column.k != NULL)
            sum = hash(sum, column.k, n * 4);
        if (column.kind == VIBROIMPACT_WORDS)
            for (size_t j = 0; column.k != NULL && j < n; j++)
                CHECK(column.k[j] >= 0 && column.k[j] <= column.n_words);
    }
    return sum;
}

/* One line of printable characters. */
static int is_a_line(const char *text)
{
    if (strlen(text) == 0 || strlen(text) > 2000)
        return 0;
    for (; *text != 0; text++)
        if ((unsigned char)*text < 32 || *text == 127)
            return 0;
    return 1;
}

/* Runs a text; its status, and the message or the complete case. */
static int run(const char *text, char **answer, uint64_t *sum, int *cut)
{
    vibroimpact_result result = 0;
    char *message, *case_text, *faults, *csv;
    int status;
    counters[2] = 0;
    set_clock(1);
    status = vibroimpact_run(text, 1, counters, &result);
    *cut = ticks > 0;
    set_clock(0);
    message = copy_text(result, VIBROIMPACT_MESSAGE);
    case_text = copy_text(result, VIBROIMPACT_CASE);
    faults = copy_text(result, VIBROIMPACT_FAULTS);
    csv = copy_text(result, VIBROIMPACT_CSV);
    CHECK(vibroimpact_status(result) == status);
    CHECK(status == VIBROIMPACT_DONE || status == VIBROIMPACT_FAILED || status == VIBROIMPACT_WRONG ||
          status == VIBROIMPACT_NO_MEMORY);
    CHECK((status == VIBROIMPACT_WRONG) == (strlen(message) > 0));
    CHECK((status == VIBROIMPACT_WRONG) == (strlen(case_text) == 0));
    CHECK((status == VIBROIMPACT_FAILED || status == VIBROIMPACT_NO_MEMORY) == (strlen(faults) > 0));
    CHECK(status != VIBROIMPACT_WRONG || is_a_line(message));
    CHECK(status != VIBROIMPACT_WRONG || strlen(csv) == 0);
    *sum = hash(sum_of(result), csv, strlen(csv));
    *answer = status == VIBROIMPACT_WRONG ? message : case_text;
    free(status == VIBROIMPACT_WRONG ? case_text : message);
    free(faults);
    free(csv);
    vibroimpact_free(result);
    return status;
}

/* One namelist, and the laws that relate its answers. */
static int32_t try(const char *text, char **answer)
{
    uint64_t sum, again;
    int cut, cut_again;
    int32_t status = run(text, answer, &sum, &cut);
    vibroimpact_result cases = 0;
    if (status != VIBROIMPACT_WRONG && !cut) {
        char *other = NULL;
        int same = run(*answer, &other, &again, &cut_again); /* the case that a result gives is that case */
        if (status != VIBROIMPACT_NO_MEMORY && same != VIBROIMPACT_NO_MEMORY) {
            CHECK(strcmp(*answer, other) == 0);
            CHECK(cut_again || same == status);
            CHECK(cut_again || again == sum);
        }
        free(other);
    }
    if (status == VIBROIMPACT_WRONG && strncmp(*answer, "the text holds", 14) != 0 && strlen(text) % 4 != 0)
        return status; /* for some, both readers are asked */
    /* a text with several cases: each is a text of its own */
    if (vibroimpact_cases(text, &cases) == VIBROIMPACT_DONE) {
        struct vibroimpact_table table;
        struct vibroimpact_column texts;
        CHECK(vibroimpact_table(cases, 0, &table) == 0 && table.n_dims == 1);
        CHECK(vibroimpact_find(cases, "cases", "text", &texts) == 0);
        CHECK(status == VIBROIMPACT_WRONG || table.rows == 1);
        for (int i = 0; status == VIBROIMPACT_WRONG && i < table.rows && i < 3; i++) {
            size_t n = vibroimpact_word(cases, texts.place, texts.k[i], NULL, 0);
            char *one = malloc(n + 1), *other = NULL;
            vibroimpact_word(cases, texts.place, texts.k[i], one, n + 1);
            CHECK(run(one, &other, &sum, &cut) != VIBROIMPACT_WRONG);
            free(one);
            free(other);
        }
    } else {
        CHECK(status == VIBROIMPACT_WRONG);
    }
    vibroimpact_free(cases);
    return status;
}

static void put(int fd, int32_t outcome, double time, const char *text, size_t n)
{
    int32_t head[3] = {outcome, (int32_t)(1e3 * time), (int32_t)n};
    char *all = malloc(sizeof head + n);
    memcpy(all, head, sizeof head);
    memcpy(all + sizeof head, text, n);
    for (size_t done = 0; done < sizeof head + n;) {
        ssize_t count = write(fd, all + done, sizeof head + n - done);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            _exit(5);
        done += (size_t)count;
    }
    free(all);
}

/* Number of allocated bytes; 0 if a sanitizer allocates. */
static size_t allocated(void)
{
    struct mallinfo2 all = mallinfo2();
    return all.uordblks + all.hblkhd;
}

/* The child: runs the namelists and writes the outcome of each. */
static void work(char **texts, int n, int fd)
{
    signal(SIGPROF, tick);
    signal(SIGALRM, tick);
    for (int i = 0; i < n; i++) {
        char *answer = NULL;
        double begin = now(), time = 0;
        int32_t outcome = 0;
        size_t before = 1;
        law = NULL;
        if (ftruncate(2, 0) == 0) /* what the case says */
            lseek(2, 0, SEEK_SET);
        for (int turn = 0; turn < 4 && law == NULL; turn++) { /* memory kept only once is a cache of a library */
            free(answer);
            before = allocated();
            outcome = try(texts[i], &answer);
            time = time > 0 ? time : now() - begin;
            if (allocated() <= before + malloc_usable_size(answer) + 8)
                break;
            if (turn == 3)
                outcome = LEAK;
        }
        if (law != NULL) {
            char *text = malloc(strlen(law) + strlen(answer) + 20);
            sprintf(text, "not true: %s\n%s", law, answer);
            free(answer);
            answer = text;
            outcome = BROKEN_LAW;
        }
        put(fd, outcome, time, answer, strlen(answer));
        free(answer);
    }
    _exit(__lsan_do_recoverable_leak_check != NULL && __lsan_do_recoverable_leak_check() ? LEAK : 0);
}

/* The contents of a file, up to a number of bytes. */
static char *read_all(int fd, size_t most)
{
    char *text = calloc(1, most + 1);
    size_t n = 0;
    ssize_t count;
    while (n < most && (count = pread(fd, text + n, most - n, (off_t)n)) > 0)
        n += (size_t)count;
    return text;
}

/* Runs namelists in a child, passes on its output, and returns how many it finished. */
static int spawn(char **texts, int n, int *status, char **said)
{
    int ends[2], done = 0, log = memfd_create("stderr", 0);
    pid_t child;
    if (log < 0 || pipe(ends) != 0 || (child = fork()) < 0) {
        perror("namelists");
        exit(3);
    }
    if (child == 0) {
        struct rlimit core = {0, 0};
        setrlimit(RLIMIT_CORE, &core);
        close(ends[0]);
        close(fileno(in)); /* a child that ends by exit would move the place in the file */
        dup2(log, 2);
        dup2(open("/dev/null", O_RDWR), 0);
        dup2(0, 1);
        work(texts, n, ends[1]);
    }
    close(ends[1]);
    FILE *from = fdopen(ends[0], "rb");
    int32_t head[3];
    while (fread(head, sizeof head, 1, from) == 1) {
        char *text = malloc((size_t)head[2] + 1);
        if (fread(text, 1, (size_t)head[2], from) != (size_t)head[2])
            break;
        fwrite(head, sizeof head, 1, out);
        fwrite(text, 1, (size_t)head[2], out);
        free(text);
        done++;
    }
    fclose(from);
    while (waitpid(child, status, 0) < 0 && errno == EINTR)
        ;
    *said = read_all(log, 20000);
    close(log);
    return done;
}

static void tell(int32_t outcome, const char *said)
{
    int32_t head[3] = {outcome, 0, (int32_t)strlen(said)};
    fwrite(head, sizeof head, 1, out);
    fwrite(said, 1, strlen(said), out);
}

int main(int count, char **arguments)
{
    static char *texts[MOST];
    uint32_t length;
    int n, first, batch;
    in = count == 4 ? fopen(arguments[1], "rb") : NULL;
    if (in == NULL) {
        fputs("usage: namelists FILE BUDGET BATCH\n", stderr);
        return 2;
    }
    budget = atof(arguments[2]);
    batch = atoi(arguments[3]);
    batch = batch < 1 || batch > MOST ? MOST : batch;
    out = stdout;
    /* a case that needs too much memory is refused, not killed by the system */
    if (__lsan_do_recoverable_leak_check == NULL) {
        struct rlimit room = {(rlim_t)2 << 30, (rlim_t)2 << 30};
        setrlimit(RLIMIT_AS, &room);
    }
    do {
        for (n = 0; n < batch && fread(&length, 4, 1, in) == 1; n++) {
            texts[n] = malloc((size_t)length + 1);
            if (fread(texts[n], 1, length, in) != length)
                return 3;
            texts[n][length] = 0;
        }
        for (first = 0; first < n;) {
            char *said;
            int status, done;
            fflush(out);
            done = spawn(texts + first, n - first, &status, &said);
            if (first + done < n)
                tell(strstr(said, "the case does not end") ? HANG : BREAKDOWN, said);
            else if (status != 0)
                tell(LEAK_IN_BATCH, said);
            first += done + 1;
            free(said);
        }
        for (int i = 0; i < n; i++)
            free(texts[i]);
    } while (n == batch);
    fclose(in);
    return 0;
}
