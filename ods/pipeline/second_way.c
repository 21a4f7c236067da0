/* Differences of range that several bodies share with fainter echoes behind them: see second_way.py. */

#include "ods/pipeline/measure/echo.h"

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

/* An echo's place and level. */
typedef struct {
    double near_m, bearing_rad, snr_db, level_db;
} Heard;

/* A body and an echo that may be its own. */
typedef struct {
    int64_t body, echo;
    double later_m;
} Pair;

/* Fills bodies with the numbers of the bodies among echoes; returns how many there are. */
static int64_t find_bodies(const Heard *echoes, int64_t count, int64_t *bodies)
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
static int64_t find_pairs(const Heard *echoes, int64_t count, const int64_t *bodies, int64_t of_bodies, Pair *pairs)
{
    int64_t found = 0;
    for (int64_t i = 0; i < of_bodies; i++)
        for (int64_t k = 0; k < count; k++) {
            const Heard body = echoes[bodies[i]], echo = echoes[k];
            if (body.level_db - echo.level_db >= FAINTER_DB && fabs(echo.bearing_rad - body.bearing_rad) <= SAME_RAD
                && echo.near_m > body.near_m)
                pairs[found++] = (Pair){bodies[i], k, echo.near_m - body.near_m};
        }
    return found;
}

/* Whether the bodies show a way that is longer by `later_m`; marks: work space, one an echo. */
static bool is_shown(const Heard *echoes, const int64_t *bodies, int64_t of_bodies, const Pair *pairs, int64_t count,
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

/* Adds the echoes to those that were heard. a_count: what a count of amplitude is worth, dB; 0: it is linear. */
static void add(const Echo *echoes, int64_t count, double a_count, Heard *heard)
{
    for (int64_t k = 0; k < count; k++) {
        const Echo *e = &echoes[k];
        const double level_db = a_count > 0.0 ? e->amplitude * a_count : 20.0 * log10(larger(e->amplitude, 1e-6));
        heard[k] = (Heard){e->near_m, e->bearing_rad, e->snr_db, level_db};
    }
}

/* Lets votes (steps,), the share of the last pings that show a way longer by (k + 1) * step_m, follow by a weight;
   returns the largest. a_count: of an echo's amplitude. */
KERNEL_FLOAT(vote_for_ways, ECHO "[found] echoes, " ECHO "[few] faint, float a_count, float far_m, float step_m, "
                            "float weight, out f8[steps] votes")
{
    const int64_t count = SIZE(0, 0) + SIZE(1, 0);
    const double weight = FLOAT(5);
    double *votes = ARRAY(double, 6), largest = 0.0;
    int64_t bodies[MOST_BODIES];
    bool *marks = ZEROS(bool, count);
    Heard *heard = SCRATCH(Heard, count);
    Pair *pairs = SCRATCH(Pair, MOST_BODIES * count);
    add(ARRAY(const Echo, 0), SIZE(0, 0), FLOAT(2), heard);
    add(ARRAY(const Echo, 1), SIZE(1, 0), FLOAT(2), heard + SIZE(0, 0));
    const int64_t of_bodies = find_bodies(heard, count, bodies);
    const int64_t of_pairs = find_pairs(heard, count, bodies, of_bodies, pairs);
    for (int64_t k = 0; k < SIZE(6, 0); k++) {
        const double later_m = (double)(k + 1) * FLOAT(4);
        const bool shown =
            of_pairs >= FEWEST && is_shown(heard, bodies, of_bodies, pairs, of_pairs, FLOAT(3), later_m, marks);
        votes[k] += weight * ((shown ? 1.0 : 0.0) - votes[k]);
        largest = larger(largest, votes[k]);
    }
    return largest;
}
