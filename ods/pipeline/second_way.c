/* Differences of range that several bodies share with fainter echoes behind them: see second_way.py. */

#include "kernel.h"

/* Bodies of a ping that are looked at: those within so many dB of the loudest, and so many at most. */
#define BODY_DB 10.0
#define MOST_BODIES 16
/* The echo behind is fainter by so many dB, and stands in the same direction and at the difference, rad and m. */
#define FAINTER_DB 5.0
#define SAME_RAD 0.026
#define SAME_M 0.3
/* So many bodies, and so large a share of those that have the difference within the image, show it. */
#define FEWEST 2
#define SHARE 0.6

typedef struct {
    double near_m, bearing_rad, snr_db, level_db;
} Echo;

/* Whether an echo is behind a body as its echo by a way that is longer by `later_m`. */
static bool is_behind(Echo body, Echo echo, double later_m)
{
    return body.level_db - echo.level_db >= FAINTER_DB && fabs(echo.bearing_rad - body.bearing_rad) <= SAME_RAD
           && fabs(echo.near_m - body.near_m - later_m) <= SAME_M;
}

/* Whether an echo is behind any of the echoes in that way. */
static bool is_behind_any(const Echo *bodies, int64_t count, Echo echo, double later_m)
{
    for (int64_t k = 0; k < count; k++)
        if (is_behind(bodies[k], echo, later_m))
            return true;
    return false;
}

/* Whether the bodies of a ping show a way that is longer by `later_m`. */
static bool is_shown(const Echo *echoes, int64_t count, const Echo *bodies, int64_t of_bodies, double far_m, double later_m)
{
    int64_t within = 0, shown = 0;
    for (int64_t i = 0; i < of_bodies; i++) {
        if (is_behind_any(bodies, of_bodies, bodies[i], later_m))
            continue; /* it is no body then */
        bool found = false;
        within += bodies[i].near_m + later_m < far_m;
        for (int64_t k = 0; k < count && !found; k++)
            found = is_behind(bodies[i], echoes[k], later_m);
        shown += found;
    }
    return shown >= FEWEST && (double)shown >= SHARE * (double)within;
}

/* Lets votes (steps,), the share of the last pings that show a way longer by (k + 1) * step_m, follow by a weight. */
KERNEL(vote_for_ways, "f8[count,4] echoes, float far_m, float step_m, float weight, out f8[steps] votes")
{
    const Echo *echoes = ARRAY(const Echo, 0);
    const int64_t count = SIZE(0, 0);
    Echo *bodies = SCRATCH(Echo, MOST_BODIES);
    double loudest_db = -INFINITY;
    int64_t of_bodies = 0;
    for (int64_t k = 0; k < count; k++)
        loudest_db = larger(loudest_db, echoes[k].snr_db);
    for (int64_t k = 0; k < count && of_bodies < MOST_BODIES; k++)
        if (echoes[k].snr_db >= loudest_db - BODY_DB)
            bodies[of_bodies++] = echoes[k];
    for (int64_t k = 0; k < SIZE(4, 0); k++) {
        const double later_m = (double)(k + 1) * FLOAT(2);
        const bool shown = of_bodies >= FEWEST && is_shown(echoes, count, bodies, of_bodies, FLOAT(1), later_m);
        ARRAY(double, 4)[k] += FLOAT(3) * ((shown ? 1.0 : 0.0) - ARRAY(double, 4)[k]);
    }
}
