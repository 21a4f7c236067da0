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

/* A body and an echo that may be its own. */
typedef struct {
    int64_t body, echo;
    double later_m;
} Pair;

/* Fills bodies with the numbers of the bodies among echoes; returns how many there are. */
static int64_t find_bodies(const Echo *echoes, int64_t count, int64_t *bodies)
{
    double loudest_db = -INFINITY;
    int64_t found = 0;
    for (int64_t k = 0; k < count; k++)
        loudest_db = larger(loudest_db, echoes[k].snr_db);
    for (int64_t k = 0; k < count && found < MOST_BODIES; k++)
        if (echoes[k].snr_db >= loudest_db - BODY_DB)
            bodies[found++] = k;
    return found;
}

/* Fills pairs with the bodies and fainter echoes behind them, by the bodies; returns how many there are. */
static int64_t find_pairs(const Echo *echoes, int64_t count, const int64_t *bodies, int64_t of_bodies, Pair *pairs)
{
    int64_t found = 0;
    for (int64_t i = 0; i < of_bodies; i++)
        for (int64_t k = 0; k < count; k++) {
            const Echo body = echoes[bodies[i]], echo = echoes[k];
            if (body.level_db - echo.level_db >= FAINTER_DB && fabs(echo.bearing_rad - body.bearing_rad) <= SAME_RAD
                && echo.near_m > body.near_m)
                pairs[found++] = (Pair){bodies[i], k, echo.near_m - body.near_m};
        }
    return found;
}

/* Whether the bodies show a way that is longer by `later_m`; marks: work space, one an echo. */
static bool is_shown(const Echo *echoes, const int64_t *bodies, int64_t of_bodies, const Pair *pairs, int64_t count,
                     double far_m, double later_m, bool *marks)
{
    int64_t within = 0, shown = 0, before = -1;
    for (int64_t i = 0; i < of_bodies; i++)
        marks[bodies[i]] = false;
    for (int64_t p = 0; p < count; p++)
        if (fabs(pairs[p].later_m - later_m) <= SAME_M)
            marks[pairs[p].echo] = true; /* it is no body then */
    for (int64_t i = 0; i < of_bodies; i++)
        within += !marks[bodies[i]] && echoes[bodies[i]].near_m + later_m < far_m;
    for (int64_t p = 0; p < count; p++)
        if (fabs(pairs[p].later_m - later_m) <= SAME_M && !marks[pairs[p].body] && pairs[p].body != before) {
            before = pairs[p].body;
            shown++;
        }
    return shown >= FEWEST && (double)shown >= SHARE * (double)within;
}

/* Lets votes (steps,), the share of the last pings that show a way longer by (k + 1) * step_m, follow by a weight. */
KERNEL(vote_for_ways, "f8[count,4] echoes, float far_m, float step_m, float weight, out f8[steps] votes")
{
    const Echo *echoes = ARRAY(const Echo, 0);
    const int64_t count = SIZE(0, 0);
    int64_t bodies[MOST_BODIES];
    bool *marks = ZEROS(bool, count);
    Pair *pairs = SCRATCH(Pair, MOST_BODIES * count);
    const int64_t of_bodies = find_bodies(echoes, count, bodies);
    const int64_t of_pairs = find_pairs(echoes, count, bodies, of_bodies, pairs);
    for (int64_t k = 0; k < SIZE(4, 0); k++) {
        const double later_m = (double)(k + 1) * FLOAT(2);
        const bool shown =
            of_pairs >= FEWEST && is_shown(echoes, bodies, of_bodies, pairs, of_pairs, FLOAT(1), later_m, marks);
        ARRAY(double, 4)[k] += FLOAT(3) * ((shown ? 1.0 : 0.0) - ARRAY(double, 4)[k]);
    }
}
