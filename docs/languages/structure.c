/* cc structure.c -o structure $(pkg-config --cflags --libs vibroimpact) */
#include <stdio.h>
#include <vibroimpact.h>

static const char text[] =
    "&structure mass = 1, 0.1, damping = 0.02, 0, stiffness = 1, 0 /\n"
    "&gap direction = -1, 1, opening = 0.5, restitution = 0.8 /\n"
    "&gap direction = 1, -1, opening = 0.5, restitution = 0.8 /\n"
    "&load frequency = 1.04, sine = 0.1, 0 /\n"
    "&simulate cycles = 4 /\n";

int main(void)
{
    vibroimpact_result result;
    struct vibroimpact_column time, gap, speed;
    int i, status = vibroimpact_run(text, 0, NULL, &result);

    if (status == VIBROIMPACT_WRONG) {
        char message[700];
        vibroimpact_text(result, VIBROIMPACT_MESSAGE, message, sizeof message);
        fprintf(stderr, "line %d: %s\n", vibroimpact_line(result), message);
    } else if (vibroimpact_find(result, "events", "time", &time) == 0 &&
               vibroimpact_find(result, "events", "gap", &gap) == 0 &&
               vibroimpact_find(result, "events", "speed", &speed) == 0) {
        for (i = 0; i < time.shape[0]; i++)
            printf("%.10f %d %.10f\n", time.x[i], (int)gap.k[i], speed.x[i]);
    }
    vibroimpact_free(result);
    return status;
}
