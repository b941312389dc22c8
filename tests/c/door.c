/* Called by tests/c/test_c_door.py with the name of an action and a namelist file.
 * A law that does not hold is reported on stderr, with exit status 9. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include <vibroimpact.h>

#define CHECK(law) \
    do { \
        if (!(law)) { \
            fprintf(stderr, "line %d: not true: %s\n", __LINE__, #law); \
            exit(9); \
        } \
    } while (0)

static char *copy_text(vibroimpact_result result, int what)
{
    size_t n = vibroimpact_text(result, what, NULL, 0);
    char *text = malloc(n + 1);
    CHECK(vibroimpact_text(result, what, text, n + 1) == n);
    CHECK(strlen(text) == n);
    return text;
}

static char *copy_word(vibroimpact_result result, int column, int value)
{
    size_t n = vibroimpact_word(result, column, value, NULL, 0);
    char *text = malloc(n + 1);
    CHECK(vibroimpact_word(result, column, value, text, n + 1) == n);
    return text;
}

static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text;
    long n;
    CHECK(file != NULL);
    fseek(file, 0, SEEK_END);
    n = ftell(file);
    rewind(file);
    text = malloc((size_t)n + 1);
    CHECK(fread(text, 1, (size_t)n, file) == (size_t)n);
    text[n] = 0;
    fclose(file);
    return text;
}

static void print_text(vibroimpact_result result, int what)
{
    char *text = copy_text(result, what);
    fputs(text, stdout);
    free(text);
}

/* As the program: the CSV on stdout, messages on stderr, and the status as exit status. */
static int show(const char *text)
{
    vibroimpact_result result;
    int status = vibroimpact_run(text, 1, NULL, &result);
    char *faults;
    CHECK(vibroimpact_status(result) == status);
    print_text(result, VIBROIMPACT_CSV);
    faults = copy_text(result, VIBROIMPACT_FAULTS);
    fputs(faults, stderr);
    CHECK((status == VIBROIMPACT_FAILED) == (strlen(faults) > 0));
    free(faults);
    vibroimpact_free(result);
    return status;
}

/* Status, line and message of a text that may be wrong. */
static int refuse(const char *text)
{
    vibroimpact_result result;
    int status = vibroimpact_run(text, 1, NULL, &result);
    struct vibroimpact_table table;
    CHECK(vibroimpact_table(result, 0, &table) == (status == 2 ? VIBROIMPACT_NO_RESULT : 0));
    CHECK(status != 2 || vibroimpact_text(result, VIBROIMPACT_CSV, NULL, 0) == 0);
    CHECK(status != 2 || vibroimpact_text(result, VIBROIMPACT_CASE, NULL, 0) == 0);
    printf("%d %d ", status, vibroimpact_line(result));
    print_text(result, VIBROIMPACT_MESSAGE);
    vibroimpact_free(result);
    return 0;
}

/* All tables and columns: the laws of the form, and one line for each on stdout. */
static int walk(const char *text)
{
    vibroimpact_result result;
    struct vibroimpact_table table, parent;
    struct vibroimpact_column column, again;
    int n_tables = 0, filled = 0, i, j;
    int status = vibroimpact_run(text, 1, NULL, &result);
    memset(&column, 0, sizeof column); /* padding as well */
    memset(&again, 0, sizeof again);
    CHECK(status == VIBROIMPACT_DONE || status == VIBROIMPACT_FAILED);
    for (; vibroimpact_table(result, n_tables, &table) == 0; n_tables++) {
        int32_t rows = 1;
        CHECK(strlen(table.name) > 0 && table.n_dims >= 0 && table.n_dims <= 3);
        for (i = 0; i < 3; i++) {
            CHECK((strlen(table.dims[i]) > 0) == (i < table.n_dims));
            CHECK(i < table.n_dims ? table.sizes[i] >= 0 : table.sizes[i] == 1);
            rows *= table.sizes[i];
        }
        CHECK(table.rows == rows);
        CHECK((table.parent < 0) == (table.owners == NULL));
        if (table.parent >= 0) {
            CHECK(table.parent < n_tables);
            CHECK(vibroimpact_table(result, table.parent, &parent) == 0);
            for (i = 0; i < rows; i++)
                CHECK(table.owners[i] >= 1 && table.owners[i] <= parent.rows);
        }
        printf("table %s %d\n", table.name, rows);
    }
    CHECK(vibroimpact_table(result, -1, &table) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_column(result, -1, &column) == VIBROIMPACT_NO_RESULT);
    for (i = 0; vibroimpact_column(result, i, &column) == 0; i++) {
        long n = 1, each = column.kind == VIBROIMPACT_COMPLEXES ? 2 : 1;
        double sum = 0;
        CHECK(column.place == i && strlen(column.meaning) > 0);
        CHECK(vibroimpact_find(result, column.table, column.name, &again) == 0);
        CHECK(memcmp(&again, &column, sizeof column) == 0);
        if (column.table_place < 0) {
            CHECK(column.x == NULL && column.k == NULL);
            continue;
        }
        CHECK(vibroimpact_table(result, column.table_place, &table) == 0);
        CHECK(strcmp(table.name, column.table) == 0);
        CHECK(column.n_dims == table.n_dims + (strlen(column.each) > 0));
        for (j = 0; j < 4; j++) {
            CHECK(j < column.n_dims || column.shape[j] == 1);
            n *= column.shape[j];
        }
        CHECK(n % (table.rows > 0 ? table.rows : 1) == 0);
        for (j = 0; j < table.n_dims; j++)
            CHECK(column.shape[column.n_dims - table.n_dims + j] == table.sizes[j]);
        if (column.kind == VIBROIMPACT_REALS || column.kind == VIBROIMPACT_COMPLEXES) {
            CHECK(column.x != NULL && column.k == NULL);
            for (j = 0; j < n * each; j++)
                sum += isfinite(column.x[j]) ? column.x[j] : 0;
        } else {
            CHECK(column.k != NULL && column.x == NULL);
            for (j = 0; j < n; j++) {
                sum += column.k[j];
                if (column.kind == VIBROIMPACT_TRUTHS)
                    CHECK(column.k[j] == 0 || column.k[j] == 1);
                if (column.kind == VIBROIMPACT_VERDICTS)
                    CHECK(column.k[j] >= -1 && column.k[j] <= 1);
                if (column.kind == VIBROIMPACT_WORDS)
                    CHECK(column.k[j] >= 0 && column.k[j] <= column.n_words);
            }
        }
        for (j = 2; j <= column.n_words; j++) { /* words are unique */
            char *word = copy_word(result, i, j), *other = copy_word(result, i, j - 1);
            CHECK(strcmp(word, other) != 0);
            free(word);
            free(other);
        }
        CHECK(vibroimpact_word(result, i, 0, NULL, 0) == 0);
        CHECK(vibroimpact_word(result, i, column.n_words + 1, NULL, 0) == 0);
        printf("column %s.%s %.17g\n", column.table, column.name, sum);
        filled++;
    }
    CHECK(n_tables > 0 && filled > 0);
    vibroimpact_free(result);
    return 0;
}

/* Each case of a text is run by its own text, and written to NAME.csv. */
static int write_all(const char *text)
{
    vibroimpact_result cases, result;
    struct vibroimpact_column names, studies, texts, lines;
    struct vibroimpact_table table;
    char message[400], path[200];
    int i;
    CHECK(vibroimpact_cases(text, &cases) == VIBROIMPACT_DONE);
    CHECK(vibroimpact_table(cases, 0, &table) == 0 && table.n_dims == 1);
    CHECK(vibroimpact_find(cases, "cases", "name", &names) == 0);
    CHECK(vibroimpact_find(cases, "cases", "study", &studies) == 0);
    CHECK(vibroimpact_find(cases, "cases", "text", &texts) == 0);
    CHECK(vibroimpact_find(cases, "cases", "line", &lines) == 0);
    for (i = 0; i < table.rows; i++) {
        char *name = copy_word(cases, names.place, names.k[i]);
        char *study = copy_word(cases, studies.place, studies.k[i]);
        char *one = copy_word(cases, texts.place, texts.k[i]);
        CHECK(vibroimpact_run(one, 1, NULL, &result) != VIBROIMPACT_WRONG);
        snprintf(path, sizeof path, "%s.csv", name);
        message[0] = '?';
        CHECK(vibroimpact_write(result, path, message, sizeof message) == 0 && message[0] == 0);
        printf("%s %s %d\n", name, study, lines.k[i]);
        CHECK(vibroimpact_write(result, "no/such/folder/x.csv", message, sizeof message) == 1);
        CHECK(strlen(message) > 0);
        vibroimpact_free(result);
        free(name);
        free(study);
        free(one);
    }
    vibroimpact_free(cases);
    return 0;
}

static int32_t counters[3];

static void *stop_soon(void *unused)
{
    (void)unused;
    while (__atomic_load_n(&counters[0], __ATOMIC_RELAXED) == 0)
        usleep(1000);
    __atomic_store_n(&counters[2], 1, __ATOMIC_RELAXED);
    return NULL;
}

/* A second thread stops the case as soon as part of its work is done. */
static int stop(const char *text)
{
    vibroimpact_result result;
    pthread_t thread;
    int status;
    CHECK(pthread_create(&thread, NULL, stop_soon, NULL) == 0);
    status = vibroimpact_run(text, 1, counters, &result);
    pthread_join(thread, NULL);
    CHECK(status != VIBROIMPACT_WRONG);
    CHECK(counters[0] > 0 && counters[0] < counters[1]); /* work was left */
    print_text(result, VIBROIMPACT_CUT);
    vibroimpact_free(result);
    return 0;
}

struct job {
    const char *text;
    char *csv;
};

static void *work(void *pointer)
{
    struct job *job = pointer;
    int i;
    for (i = 0; i < 5; i++) {
        vibroimpact_result result, wrong;
        CHECK(vibroimpact_run(job->text, 1 + i % 2, NULL, &result) != VIBROIMPACT_WRONG);
        CHECK(vibroimpact_run("&system xi = 2 /", 1, NULL, &wrong) == VIBROIMPACT_WRONG);
        free(job->csv);
        job->csv = copy_text(result, VIBROIMPACT_CSV);
        vibroimpact_free(result);
        vibroimpact_free(wrong);
    }
    return NULL;
}

/* Eight threads run the same case, five times each, with the least stack that is documented. */
static int run_at_once(const char *text)
{
    enum { N = 8 };
    pthread_t threads[N];
    struct job jobs[N];
    pthread_attr_t attributes;
    int i;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, 2u << 20);
    for (i = 0; i < N; i++) {
        jobs[i].text = text;
        jobs[i].csv = NULL;
        CHECK(pthread_create(&threads[i], &attributes, work, &jobs[i]) == 0);
    }
    for (i = 0; i < N; i++)
        pthread_join(threads[i], NULL);
    for (i = 1; i < N; i++)
        CHECK(strcmp(jobs[i].csv, jobs[0].csv) == 0);
    fputs(jobs[0].csv, stdout);
    for (i = 0; i < N; i++)
        free(jobs[i].csv);
    return 0;
}

static void *run_small(void *pointer)
{
    struct job *job = pointer;
    vibroimpact_result result;
    int status = vibroimpact_run(job->text, 1, NULL, &result);
    CHECK(status == VIBROIMPACT_DONE || status == VIBROIMPACT_NO_MEMORY);
    free(job->csv);
    job->csv = copy_text(result, status == VIBROIMPACT_DONE ? VIBROIMPACT_CSV : VIBROIMPACT_FAULTS);
    vibroimpact_free(result);
    return NULL;
}

/* Threads with smaller stacks than that: each prints the result, or why there is none. */
static int run_in_small_stacks(const char *text)
{
    pthread_attr_t attributes;
    struct job job = {text, NULL};
    size_t size;
    pthread_attr_init(&attributes);
    for (size = 64u << 10; size <= 1u << 20; size *= 2) {
        pthread_t thread;
        pthread_attr_setstacksize(&attributes, size);
        CHECK(pthread_create(&thread, &attributes, run_small, &job) == 0);
        pthread_join(thread, NULL);
        printf("%d\n%s", (int)(size >> 10), job.csv);
    }
    free(job.csv);
    return 0;
}

/* A result is copied, column by column, into one that is filled from outside. */
static int refill(const char *text)
{
    vibroimpact_result result, copy;
    struct vibroimpact_table table, parent;
    struct vibroimpact_column column;
    char *remarks, *lines, *wanted, *got;
    int i, j;
    CHECK(vibroimpact_run(text, 1, NULL, &result) == VIBROIMPACT_DONE);
    lines = copy_text(result, VIBROIMPACT_CASE);
    CHECK(vibroimpact_new(lines, &copy) == VIBROIMPACT_DONE);
    for (i = 0; vibroimpact_table(result, i, &table) == 0; i++) {
        char dims[60] = "";
        for (j = 0; j < table.n_dims; j++) {
            strcat(dims, table.dims[j]);
            strcat(dims, " ");
        }
        if (table.parent >= 0)
            CHECK(vibroimpact_table(result, table.parent, &parent) == 0);
        CHECK(vibroimpact_open(copy, table.name, dims, table.n_dims, table.sizes,
                               table.parent >= 0 ? parent.name : NULL,
                               table.parent >= 0 ? table.rows : 0, table.owners) == 0);
    }
    CHECK(vibroimpact_text(copy, VIBROIMPACT_CSV, NULL, 0) == 0); /* nothing is filled yet */
    for (i = 0; vibroimpact_column(result, i, &column) == 0; i++) {
        int n = column.shape[0] * column.shape[1] * column.shape[2] * column.shape[3];
        if (column.table_place < 0)
            continue;
        if (column.x != NULL) {
            if (column.kind == VIBROIMPACT_COMPLEXES)
                n *= 2;
            CHECK(vibroimpact_put_reals(copy, column.table, column.name, n, column.x) == 0);
        } else if (column.kind == VIBROIMPACT_WORDS) {
            char words[4000] = "";
            for (j = 1; j <= column.n_words; j++) {
                char *word = copy_word(result, i, j);
                if (j > 1)
                    strcat(words, "\n");
                strcat(words, word);
                free(word);
            }
            CHECK(vibroimpact_put_words(copy, column.table, column.name, n, column.k, words) == 0);
        } else {
            CHECK(vibroimpact_put_wholes(copy, column.table, column.name, n, column.k) == 0);
        }
    }
    remarks = copy_text(result, VIBROIMPACT_REMARKS);
    CHECK(vibroimpact_say(copy, NULL, remarks) == 0);
    wanted = copy_text(result, VIBROIMPACT_CSV);
    got = copy_text(copy, VIBROIMPACT_CSV);
    fputs(got, stdout);
    CHECK(strlen(wanted) > 0 && strcmp(wanted, got) == 0);
    CHECK(vibroimpact_text(copy, VIBROIMPACT_MESSAGE, NULL, 0) == 0);
    free(lines);
    free(remarks);
    free(wanted);
    free(got);
    vibroimpact_free(result);
    vibroimpact_free(copy);
    return 0;
}

/* Unsuitable values are refused with a message and change nothing. */
static void fill_wrongly(const char *text)
{
    vibroimpact_result r;
    const int32_t one[3] = {1, 1, 1}, two[2] = {2, 2}, nine[2] = {1, 9}, huge[3] = {65536, 65536, 2};
    const double x[3] = {1, 2, 3};
    CHECK(vibroimpact_new(text, &r) == VIBROIMPACT_DONE); /* a &zone */
    CHECK(vibroimpact_put_reals(r, "vertices", "r", 2, x) == 2);
    CHECK(vibroimpact_text(r, VIBROIMPACT_MESSAGE, NULL, 0) > 0);
    CHECK(vibroimpact_open(r, "a_very_long_name_", "leg", 1, two, NULL, 0, NULL) == 2);
    CHECK(vibroimpact_open(r, NULL, NULL, 0, NULL, NULL, 0, NULL) == 2);
    CHECK(vibroimpact_open(r, "vertices", "vertex", 1, two, "pieces", 2, one) == 2);
    CHECK(vibroimpact_open(r, "pieces", "piece", 2, two, NULL, 0, NULL) == 2);
    CHECK(vibroimpact_open(r, "pieces", "a b c", 3, huge, NULL, 0, NULL) == 2);
    CHECK(vibroimpact_open(r, "pieces", "piece", -1, two, NULL, 0, NULL) == 2);
    CHECK(vibroimpact_open(r, "pieces", "piece", 1, one, NULL, 0, NULL) == 0);
    CHECK(vibroimpact_open(r, "pieces", "piece", 1, one, NULL, 0, NULL) == 2);
    CHECK(vibroimpact_open(r, "vertices", "vertex", 1, two, "pieces", 2, nine) == 2);
    CHECK(vibroimpact_open(r, "vertices", "vertex", 1, two, "pieces", 1, one) == 2);
    CHECK(vibroimpact_open(r, "vertices", "vertex", 1, two, NULL, 0, NULL) == 0);
    CHECK(vibroimpact_put_reals(r, "vertices", "r", 3, x) == 2);
    CHECK(vibroimpact_put_reals(r, "vertices", "r", -3, x) == 2);
    CHECK(vibroimpact_put_reals(r, "vertices", "r", 2, NULL) == 2);
    CHECK(vibroimpact_put_reals(r, "vertices", "corner", 2, x) == 2);
    CHECK(vibroimpact_put_reals(r, "vertices", "legs", 2, x) == 2);
    CHECK(vibroimpact_put_wholes(r, "vertices", "r", 2, two) == 2);
    CHECK(vibroimpact_put_wholes(r, "pieces", "type", 1, one) == 2); /* no words */
    CHECK(vibroimpact_put_words(r, "pieces", "type", 1, two, "fold") == 2);
    CHECK(vibroimpact_put_words(r, "pieces", "loop", 1, one, "fold") == 2);
    CHECK(vibroimpact_put_words(r, "pieces", "type", 1, one, "fold") == 0);
    CHECK(vibroimpact_put_words(r, "pieces", "type", 1, one, "fold") == 2);
    CHECK(vibroimpact_put_words(r, "pieces", "detail", 1, one, "first") == 0);
    CHECK(vibroimpact_put_wholes(r, "pieces", "loop", 1, one) == 0);
    CHECK(vibroimpact_put_wholes(r, "pieces", "piece", 1, one) == 0);
    CHECK(vibroimpact_put_wholes(r, "pieces", "symmetric", 1, one) == 0);
    CHECK(vibroimpact_put_reals(r, "vertices", "r", 2, x) == 0);
    CHECK(vibroimpact_put_reals(r, "vertices", "clearance", 2, x) == 0);
    CHECK(vibroimpact_put_wholes(r, "vertices", "corner", 2, one) == 0);
    /* no vertex has a piece, so there are no rows that name one */
    CHECK(vibroimpact_text(r, VIBROIMPACT_CSV, NULL, 0) == 0);
    vibroimpact_free(r);
}

/* Null pointers, missing and freed handles, and null texts. */
static int misuse(const char *text)
{
    vibroimpact_result r, wrong;
    struct vibroimpact_table table;
    struct vibroimpact_column column;
    char out[8] = "abcdefg";
    int i;
    CHECK(vibroimpact_run(text, 1, NULL, NULL) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_cases(text, NULL) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_new(text, NULL) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_run(NULL, 1, NULL, &wrong) == VIBROIMPACT_WRONG);
    CHECK(vibroimpact_text(wrong, VIBROIMPACT_MESSAGE, NULL, 0) > 0);
    CHECK(vibroimpact_open(wrong, "a", "b", 0, NULL, NULL, 0, NULL) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_say(wrong, "a", "b") == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_cases("", &r) == VIBROIMPACT_WRONG);
    vibroimpact_free(r);
    CHECK(vibroimpact_new(text, &r) == VIBROIMPACT_DONE);
    CHECK(vibroimpact_status(r) == VIBROIMPACT_DONE);
    CHECK(vibroimpact_table(r, 0, &table) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_column(r, 0, NULL) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_column(r, 0, &column) == 0 && column.table_place == -1);
    CHECK(vibroimpact_column(r, 2147483647, &column) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_find(r, NULL, NULL, &column) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_find(r, "vertices", "r", NULL) == VIBROIMPACT_NO_RESULT);
    CHECK(vibroimpact_text(r, 99, out, sizeof out) == 0 && out[0] == 0);
    CHECK(vibroimpact_text(r, -1, out, 0) == 0);
    CHECK(vibroimpact_word(r, -1, 1, out, sizeof out) == 0);
    CHECK(vibroimpact_word(r, 2147483647, 1, out, sizeof out) == 0);
    /* the size of the buffer is respected; (size_t)-1 is unlimited */
    strcpy(out, "abcdefg");
    CHECK(vibroimpact_text(r, VIBROIMPACT_CASE, out, 4) > 3 && strlen(out) == 3 && out[4] == 'e');
    CHECK(vibroimpact_version(out, (size_t)-1) == strlen(out));
    CHECK(vibroimpact_version(NULL, 100) == strlen(out));
    fill_wrongly(text);
    vibroimpact_free(wrong);
    for (i = 0; i < 2; i++) { /* no handle, and a freed one */
        if (i == 1)
            vibroimpact_free(r);
        else
            vibroimpact_free(0);
        wrong = i == 1 ? r : 0;
        CHECK(vibroimpact_status(wrong) == VIBROIMPACT_NO_RESULT);
        CHECK(vibroimpact_line(wrong) == 0);
        CHECK(vibroimpact_text(wrong, VIBROIMPACT_JSON, NULL, 0) == 0);
        CHECK(vibroimpact_text(wrong, VIBROIMPACT_MESSAGE, NULL, 0) == 0);
        CHECK(vibroimpact_table(wrong, 0, &table) == VIBROIMPACT_NO_RESULT);
        CHECK(vibroimpact_column(wrong, 0, &column) == VIBROIMPACT_NO_RESULT);
        CHECK(vibroimpact_find(wrong, "points", "r", &column) == VIBROIMPACT_NO_RESULT);
        CHECK(vibroimpact_word(wrong, 0, 1, NULL, 0) == 0);
        CHECK(vibroimpact_write(wrong, "x.csv", NULL, 0) == VIBROIMPACT_NO_RESULT);
        CHECK(vibroimpact_say(wrong, NULL, NULL) == VIBROIMPACT_NO_RESULT);
        CHECK(vibroimpact_put_reals(wrong, "a", "b", 0, NULL) == VIBROIMPACT_NO_RESULT);
        CHECK(vibroimpact_put_wholes(wrong, "a", "b", 0, NULL) == VIBROIMPACT_NO_RESULT);
        vibroimpact_free(wrong);
    }
    return 0;
}

static long resident(void)
{
    FILE *file = fopen("/proc/self/statm", "r");
    long total, pages = 0;
    CHECK(file != NULL && fscanf(file, "%ld %ld", &total, &pages) == 2);
    fclose(file);
    return pages * sysconf(_SC_PAGESIZE);
}

/* Bytes of memory that 300 results leave behind, after 30. */
static int keep(const char *text)
{
    long before = 0;
    int i;
    for (i = 0; i < 330; i++) {
        vibroimpact_result result, cases, wrong;
        if (i == 30)
            before = resident();
        CHECK(vibroimpact_run(text, 1, NULL, &result) != VIBROIMPACT_WRONG);
        CHECK(vibroimpact_cases(text, &cases) == VIBROIMPACT_DONE);
        CHECK(vibroimpact_run("&motion /", 1, NULL, &wrong) == VIBROIMPACT_WRONG);
        free(copy_text(result, VIBROIMPACT_CSV));
        free(copy_text(result, VIBROIMPACT_JSON));
        vibroimpact_free(result);
        vibroimpact_free(cases);
        vibroimpact_free(wrong);
    }
    printf("%ld\n", resident() - before);
    return 0;
}

/* The description of a result, or of the language. */
static int describe(const char *text)
{
    vibroimpact_result result;
    if (strlen(text) > 0) {
        CHECK(vibroimpact_cases(text, &result) == VIBROIMPACT_DONE);
        print_text(result, VIBROIMPACT_JSON);
        vibroimpact_free(result);
    } else {
        size_t n = vibroimpact_describe(NULL, 0);
        char *json = malloc(n + 1);
        CHECK(vibroimpact_describe(json, n + 1) == n);
        fputs(json, stdout);
        free(json);
    }
    return 0;
}

/* Microseconds of processor time of a call: run, find a column, free. */
static int clock_calls(const char *text)
{
    clock_t begin = clock();
    int i, n = 5000;
    for (i = 0; i < n; i++) {
        vibroimpact_result result;
        struct vibroimpact_column column;
        vibroimpact_run(text, 1, NULL, &result);
        vibroimpact_find(result, "motions", "r", &column);
        vibroimpact_free(result);
    }
    printf("%.2f\n", (double)(clock() - begin) / CLOCKS_PER_SEC / n * 1e6);
    return 0;
}

int main(int n, char **arguments)
{
    static const struct {
        const char *name;
        int (*call)(const char *text);
    } things[] = {{"show", show}, {"refuse", refuse}, {"walk", walk}, {"write", write_all},
                  {"stop", stop}, {"at-once", run_at_once}, {"small", run_in_small_stacks}, {"refill", refill}, {"misuse", misuse},
                  {"keep", keep}, {"describe", describe}, {"clock", clock_calls}};
    size_t i;
    CHECK(n == 3);
    for (i = 0; i < sizeof things / sizeof *things; i++) {
        if (strcmp(arguments[1], things[i].name) == 0) {
            char *text = read_file(arguments[2]);
            int status = things[i].call(text);
            free(text);
            return status;
        }
    }
    return 9;
}
