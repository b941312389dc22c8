/* vibroimpact: stable periodic motions of a vibrating system in which a free mass collides with its walls.
 *
 * The input is a case, as the text of a namelist like those that the program vibroimpact-batch reads. The
 * output is a result: named tables with columns of numbers, which are read in place.
 *
 *     vibroimpact_result result;
 *     struct vibroimpact_column lowest;
 *     int status = vibroimpact_run(text, 1, NULL, &result);
 *     if (status != VIBROIMPACT_WRONG && vibroimpact_find(result, "points", "lowest", &lowest) == 0)
 *         printf("%g\n", lowest.x[0]);
 *     vibroimpact_free(result);
 *
 * Texts are UTF-8 and end with a null character. A null pointer stands for an empty text. No function
 * prints, stops the program or keeps any state: errors are reported by the status and, in words, by
 * vibroimpact_text(result, VIBROIMPACT_MESSAGE, ...).
 *
 * Memory: the caller owns a result, and all that its columns point to, until it frees the result. No other
 * memory is passed to the caller.
 *
 * Threads: any thread may call any function at any time, and use results of another thread. Several threads
 * may read one result at once, as long as none of them fills or frees it. A thread that runs a case needs a
 * stack of 2 MiB; POSIX threads have 8 MiB by default.
 */
#ifndef VIBROIMPACT_H
#define VIBROIMPACT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The handle of a result; 0 is none. It is an address: a handle that was freed is detected in most cases,
 * not in all, and a number that never was a handle crashes the program. */
typedef int64_t vibroimpact_result;

/* The values of an int status that functions return. */
enum {
    VIBROIMPACT_DONE = 0,     /* all went well */
    VIBROIMPACT_FAILED = 1,   /* it ran, but something failed or does not exist: VIBROIMPACT_FAULTS */
    VIBROIMPACT_WRONG = 2,    /* the text or an argument is wrong: VIBROIMPACT_MESSAGE */
    VIBROIMPACT_NO_RESULT = 3, /* no result, no such table or column, or a null pointer for the output */
    VIBROIMPACT_NO_MEMORY = 4 /* the case needs more memory or stack than is available: VIBROIMPACT_FAULTS */
};

/* Runs the one case of a text.
 *
 * threads:  largest number of threads; 0 for as many as the machine has. The numbers do not depend on it.
 * counters: three numbers, or NULL. While the case runs, the first is the work done and the second the work
 *           known so far, in units of the study; another thread may read them. It may write 1 into the third:
 *           the case then stops soon and returns what it has computed so far; for points along a line
 *           VIBROIMPACT_CUT tells how many were reached. They are set to 0 at the start. Read and write them
 *           atomically. A motion of an oscillator ignores them.
 * result:   is set whatever the status, except for VIBROIMPACT_NO_RESULT, which means that it is NULL.
 *
 * In a forked child of the process a case uses one thread.
 *
 * Returns VIBROIMPACT_DONE, VIBROIMPACT_FAILED, VIBROIMPACT_WRONG or VIBROIMPACT_NO_MEMORY. */
int vibroimpact_run(const char *text, int threads, int32_t *counters, vibroimpact_result *result);

/* Lists the cases of a text, one for each group that requests a result.
 *
 * The table `cases` of the result has a row for each, with the columns `name`, `study` and `text` of words
 * and `line` of whole numbers; `text` is the complete case as a text for vibroimpact_run.
 *
 * Returns VIBROIMPACT_DONE or VIBROIMPACT_WRONG. */
int vibroimpact_cases(const char *text, vibroimpact_result *result);

/* The status that the function that made a result returned; VIBROIMPACT_NO_RESULT if there is no result. */
int vibroimpact_status(vibroimpact_result result);

/* Line of the text, from 1, to which VIBROIMPACT_MESSAGE refers; 0 if it refers to none. */
int vibroimpact_line(vibroimpact_result result);

/* The texts of a result. Each line of a text with several lines ends with a line feed. */
enum {
    VIBROIMPACT_MESSAGE = 0, /* the error; empty if there is none */
    VIBROIMPACT_CASE = 1,    /* the complete case, with defaults filled in, as a namelist */
    VIBROIMPACT_NOTES = 2,   /* lines on what was found */
    VIBROIMPACT_FAULTS = 3,  /* lines on what failed or does not exist */
    VIBROIMPACT_REMARKS = 4, /* lines for the header of a file */
    VIBROIMPACT_CUT = 5,     /* how far it got if it was stopped within a line of points; else empty */
    VIBROIMPACT_CSV = 6,     /* the file that vibroimpact-batch writes; empty if there is none */
    VIBROIMPACT_JSON = 7     /* all except the values: texts, tables, and columns with their words */
};

/* Copies a text of a result.
 *
 * Writes at most capacity bytes to out, the last one a null character, and returns the length of the whole
 * text without that character: a second call with a capacity of this length plus one gets the whole text. out
 * may be NULL if capacity is 0. A missing text is empty. Each call generates the CSV again; for a large result
 * use vibroimpact_write. */
size_t vibroimpact_text(vibroimpact_result result, int what, char *out, size_t capacity);

/* Writes a result as the CSV file path, completely or not at all.
 *
 * The error is written to message, as by vibroimpact_text.
 *
 * Returns VIBROIMPACT_DONE or VIBROIMPACT_FAILED. */
int vibroimpact_write(vibroimpact_result result, const char *path, char *message, size_t capacity);

/* A table: a grid of rows with 0 to 3 dimensions; one without dimensions has one row. */
struct vibroimpact_table {
    char name[17];
    char dims[3][17];      /* names of the dimensions; the first one varies fastest */
    int32_t n_dims;
    int32_t sizes[3];      /* 1 where there is no dimension */
    int32_t rows;          /* the product of sizes */
    int32_t parent;        /* place of the parent table, whose rows own those of this one; -1 if none */
    const int32_t *owners; /* the row of the parent, counted from 1, that owns each row; or NULL */
};

/* The table of a result at a place, from 0. Returns VIBROIMPACT_NO_RESULT after the last one. */
int vibroimpact_table(vibroimpact_result result, int place, struct vibroimpact_table *table);

/* Kinds of values of a column. */
enum {
    VIBROIMPACT_REALS = 1,    /* x: numbers; a missing one is NaN */
    VIBROIMPACT_WHOLES = 2,   /* k: whole numbers; numbers of rows of a table count from 1 */
    VIBROIMPACT_WORDS = 3,    /* k: words, see vibroimpact_word; 0 for none */
    VIBROIMPACT_VERDICTS = 4, /* k: 1 for yes, 0 for no, -1 for unknown */
    VIBROIMPACT_TRUTHS = 5,   /* k: 1 for true, 0 for false */
    VIBROIMPACT_COMPLEXES = 6 /* x: the real and the imaginary part in turn */
};

/* A column. Its values are stored row by row; each row holds one value or, if `each` names a dimension
 * within the row, several values in succession. */
struct vibroimpact_column {
    char table[17];
    char name[25];
    char each[17];       /* name of the dimension within a row, such as impact; or empty */
    char unit[17];       /* or empty */
    char label[29];      /* name in the CSV if it differs; # stands for the place within the row */
    char meaning[161];
    int32_t kind;        /* VIBROIMPACT_REALS and so on */
    int32_t listed;      /* whether it is in the CSV */
    int32_t place;       /* of the column, from 0 */
    int32_t table_place; /* of its table, from 0; -1 if the column has no values */
    int32_t n_dims;      /* of shape: those of the table, followed by that within a row if any */
    int32_t shape[4];    /* the first one varies fastest; 1 where there is no dimension */
    int32_t n_words;     /* of a column of words */
    const double *x;     /* of VIBROIMPACT_REALS and VIBROIMPACT_COMPLEXES; else NULL */
    const int32_t *k;    /* of all else; else NULL */
};

/* The column of a result at a place, from 0. Returns VIBROIMPACT_NO_RESULT after the last one. */
int vibroimpact_column(vibroimpact_result result, int place, struct vibroimpact_column *column);

/* The column of a table by its name. Returns VIBROIMPACT_NO_RESULT if there is none; a column that is
 * declared but has no values is found, with x and k NULL. */
int vibroimpact_find(vibroimpact_result result, const char *table, const char *name,
                     struct vibroimpact_column *column);

/* The word that a value of a column of words stands for, 1 to n_words, as by vibroimpact_text. */
size_t vibroimpact_word(vibroimpact_result result, int column, int value, char *out, size_t capacity);

/* A result without tables for the case of a text, to be filled with values that were computed earlier, for
 * example those of a file. Nothing is computed; vibroimpact_open and vibroimpact_put_... fill it. */
int vibroimpact_new(const char *text, vibroimpact_result *result);

/* Opens a table of the study of the case.
 *
 * dims: names of the n_dims dimensions, separated by blanks, the one that varies fastest first.
 * parent, owners: for a child table the name of its parent, which must be open already, and the row of the
 *          parent, from 1, for each of its n_owners rows; else NULL, 0, NULL.
 *
 * This function and those below return VIBROIMPACT_DONE or VIBROIMPACT_WRONG with a message, and copy their
 * arguments. */
int vibroimpact_open(vibroimpact_result result, const char *table, const char *dims, int n_dims,
                     const int32_t *sizes, const char *parent, int n_owners, const int32_t *owners);

/* Fill a column, once, with n values, row by row: the first with numbers (for complex numbers both parts
 * count); the second with whole numbers, truths, verdicts or values of words that the study declares; the
 * third with values of words that are given as one text, separated by line feeds. */
int vibroimpact_put_reals(vibroimpact_result result, const char *table, const char *column, int n,
                          const double *values);
int vibroimpact_put_wholes(vibroimpact_result result, const char *table, const char *column, int n,
                           const int32_t *values);
int vibroimpact_put_words(vibroimpact_result result, const char *table, const char *column, int n,
                          const int32_t *values, const char *words);

/* Sets VIBROIMPACT_CUT and adds lines, each ended by a line feed, to VIBROIMPACT_REMARKS; or NULL. */
int vibroimpact_say(vibroimpact_result result, const char *cut, const char *remarks);

/* The language of namelists and the columns of all results, as JSON; as by vibroimpact_text. */
size_t vibroimpact_describe(char *out, size_t capacity);

/* The version of the library; as by vibroimpact_text. */
size_t vibroimpact_version(char *out, size_t capacity);

/* Frees a result with all that its columns point to; 0 is ignored. */
void vibroimpact_free(vibroimpact_result result);

#ifdef __cplusplus
}
#endif

#endif
