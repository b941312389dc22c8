/* The function `vibroimpact` of Octave and MATLAB: the text of a case in, a struct of tables out, each a
 * struct of columns. Words are cell arrays, whole numbers int32, the owners of a child table `owners`. */
#include <mex.h>
#include <string.h>
#include <vibroimpact.h>

static char *copy_text(vibroimpact_result result, int what)
{
    size_t n = vibroimpact_text(result, what, NULL, 0);
    char *text = mxMalloc(n + 1);
    vibroimpact_text(result, what, text, n + 1);
    return text;
}

/* One column as an array; a single dimension is a column vector. */
static mxArray *array_of(vibroimpact_result result, const struct vibroimpact_column *column)
{
    mwSize shape[4], n = 1, n_dims = column->n_dims < 2 ? 2 : column->n_dims, i;
    mxArray *array;

    for (i = 0; i < 4; i++) {
        shape[i] = column->shape[i];
        n *= shape[i];
    }
    if (column->kind == VIBROIMPACT_WORDS) {
        array = mxCreateCellArray(n_dims, shape);
        for (i = 0; i < n; i++) {
            size_t room = vibroimpact_word(result, column->place, column->k[i], NULL, 0) + 1;
            char *word = mxMalloc(room);
            vibroimpact_word(result, column->place, column->k[i], word, room);
            mxSetCell(array, i, mxCreateString(word));
            mxFree(word);
        }
    } else if (column->k != NULL) {
        array = mxCreateNumericArray(n_dims, shape, mxINT32_CLASS, mxREAL);
        memcpy(mxGetData(array), column->k, n * sizeof(int32_t));
    } else if (column->kind == VIBROIMPACT_REALS) {
        array = mxCreateNumericArray(n_dims, shape, mxDOUBLE_CLASS, mxREAL);
        memcpy(mxGetPr(array), column->x, n * sizeof(double));
    } else {
        array = mxCreateNumericArray(n_dims, shape, mxDOUBLE_CLASS, mxCOMPLEX);
        for (i = 0; i < n; i++) {
            mxGetPr(array)[i] = column->x[2 * i];
            mxGetPi(array)[i] = column->x[2 * i + 1];
        }
    }
    return array;
}

static void set_field(mxArray *target, const char *name, mxArray *value)
{
    if (mxGetFieldNumber(target, name) < 0)
        mxAddField(target, name);
    mxSetField(target, 0, name, value);
}

void mexFunction(int n_out, mxArray *out[], int n_in, const mxArray *in[])
{
    vibroimpact_result result;
    struct vibroimpact_table table;
    struct vibroimpact_column column;
    char *text;
    int status, i;

    (void)n_out;
    if (n_in != 1 || !mxIsChar(in[0]))
        mexErrMsgTxt("vibroimpact takes one text, the namelist of a case");
    text = mxArrayToString(in[0]);
    status = vibroimpact_run(text, 0, NULL, &result);
    mxFree(text);
    if (status == VIBROIMPACT_WRONG) {
        text = copy_text(result, VIBROIMPACT_MESSAGE); /* which the interpreter frees */
        vibroimpact_free(result);
        mexErrMsgTxt(text);
    }
    out[0] = mxCreateStructMatrix(1, 1, 0, NULL);
    set_field(out[0], "status", mxCreateDoubleScalar(status));
    text = copy_text(result, VIBROIMPACT_NOTES);
    set_field(out[0], "notes", mxCreateString(text));
    mxFree(text);
    for (i = 0; vibroimpact_table(result, i, &table) == VIBROIMPACT_DONE; i++) {
        mxArray *fields = mxCreateStructMatrix(1, 1, 0, NULL);
        if (table.owners != NULL) {
            mxArray *owners = mxCreateNumericMatrix(table.rows, 1, mxINT32_CLASS, mxREAL);
            memcpy(mxGetData(owners), table.owners, table.rows * sizeof(int32_t));
            set_field(fields, "owners", owners);
        }
        set_field(out[0], table.name, fields);
    }
    for (i = 0; vibroimpact_column(result, i, &column) == VIBROIMPACT_DONE; i++)
        if (column.table_place >= 0)
            set_field(mxGetField(out[0], 0, column.table), column.name, array_of(result, &column));
    vibroimpact_free(result);
}
