/* cc response.c -o response $(pkg-config --cflags --libs vibroimpact) */
#include <stdio.h>
#include <vibroimpact.h>

static const char text[] =
    "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
    "&response r_min = 1.00, r_max = 1.04, r_points = 5, clearance = 25, states = 6 /\n";

int main(void)
{
    vibroimpact_result result;
    struct vibroimpact_column r, lowest, highest;
    int i, status = vibroimpact_run(text, 0, NULL, &result);

    if (status == VIBROIMPACT_WRONG) {
        char message[700];
        vibroimpact_text(result, VIBROIMPACT_MESSAGE, message, sizeof message);
        fprintf(stderr, "line %d: %s\n", vibroimpact_line(result), message);
    } else if (vibroimpact_find(result, "points", "r", &r) == 0 &&
               vibroimpact_find(result, "points", "lowest", &lowest) == 0 &&
               vibroimpact_find(result, "points", "highest", &highest) == 0) {
        for (i = 0; i < r.shape[0]; i++)
            printf("%.2f %.10f %.10f\n", r.x[i], lowest.x[i], highest.x[i]);
    }
    vibroimpact_free(result);
    return status;
}
