/* Differences of range that several bodies share with fainter echoes behind them: see second_way.py. */

#include "ods/pipeline/measure/echo.h"

/* Bodies of a ping that are looked at: those within so many dB of the loudest, and so many at most. */
#define BODY_DB 10.0
#define MOST_BODIES 16
/* The echo behind is fainter by so many dB, and stands in the same direction and at the difference, rad and m. */
#define FAINTER_DB 5.0
#define SAME_RAD 0.026
#define SAME_M 0.3
/* Echoes by one way are weaker than their bodies by the same, apart from speckle, dB. */
#define SAME_DB 6.0
/* So many bodies show a way that is not known yet, and so large a share of those whose echo by it is to be received. */
#define FEWEST 2
#define SHARE 0.6
/* Bodies stand behind bodies: at any difference as many show one by chance as pairs at others let expect (Poisson), and it
   is no way where one of all differences would have so many with a greater probability than this. */
#define CHANCE 0.01

/* An echo's place and level. */
typedef struct {
    double near_m, end_m, bearing_rad, snr_db, level_db;
} Received;

/* A body and an echo that may be its own. */
typedef struct {
    int64_t body, echo;
    double later_m;
} Pair;

static bool is_in_direction(Received a, Received b) { return fabs(a.bearing_rad - b.bearing_rad) <= SAME_RAD; }

/* Whether an echo begins within a louder one: another plane sees the same body. */
static bool is_seen_louder(const Received *echoes, int64_t count, Received echo)
{
    for (int64_t k = 0; k < count; k++)
        if (echoes[k].level_db > echo.level_db && is_in_direction(echoes[k], echo)
            && echo.near_m >= echoes[k].near_m - SAME_M && echo.near_m <= echoes[k].end_m)
            return true;
    return false;
}

/* Fills bodies with the numbers of the bodies among echoes; returns how many there are. */
static int64_t find_bodies(const Received *echoes, int64_t count, int64_t *bodies)
{
    double loudest_db = -INFINITY;
    int64_t found = 0;
    for (int64_t k = 0; k < count; k++)
        loudest_db = larger(loudest_db, echoes[k].snr_db);
    for (int64_t k = 0; k < count && found < MOST_BODIES; k++)
        if (echoes[k].snr_db >= loudest_db - BODY_DB && !is_seen_louder(echoes, count, echoes[k]))
            bodies[found++] = k;
    return found;
}

/* Fills pairs with the bodies and fainter echoes up to most_m behind them, by the bodies; returns how many there are. */
static int64_t find_pairs(const Received *echoes, int64_t count, const int64_t *bodies, int64_t of_bodies, double most_m,
                          Pair *pairs)
{
    int64_t found = 0;
    for (int64_t i = 0; i < of_bodies; i++)
        for (int64_t k = 0; k < count; k++) {
            const Received body = echoes[bodies[i]], echo = echoes[k];
            if (body.level_db - echo.level_db >= FAINTER_DB && is_in_direction(echo, body)
                && echo.near_m > body.end_m && echo.near_m - body.near_m <= most_m)
                pairs[found++] = (Pair){bodies[i], k, echo.near_m - body.near_m};
        }
    return found;
}

/* What a ping's bodies say of a way: so many show it, of so many whose echo by it is to be received. */
typedef struct {
    int64_t shown, expected, others; /* others: pairs at other differences */
    double weaker_db;                /* by so much echoes are weaker */
} Said;

/* A way that is looked for. */
typedef struct {
    double later_m, weaker_db; /* weaker_db: of the pings before; NAN: not known */
    double far_m, from_db;     /* of the image, and from how many dB on an echo is received */
} Way;

static bool is_by(Way way, Pair pair) { return fabs(pair.later_m - way.later_m) <= SAME_M; }

/* Returns by how much echoes by a way are weaker than their bodies, dB; NAN without any. */
static double weaker_by(const Received *echoes, const Pair *pairs, int64_t count, Way way)
{
    double sum_db = 0.0, of = 0.0;
    for (int64_t p = 0; p < count; p++)
        if (is_by(way, pairs[p]))
            sum_db += echoes[pairs[p].body].level_db - echoes[pairs[p].echo].level_db, of += 1.0;
    return sum_db / of;
}

/* Returns what bodies say of a way; marks: work space, one an echo. */
static Said said_by(const Received *echoes, const int64_t *bodies, int64_t of_bodies, const Pair *pairs, int64_t count,
                    Way way, bool *marks)
{
    Said said = {0, 0, 0, weaker_by(echoes, pairs, count, way)};
    const double usual_db = isnan(way.weaker_db) ? said.weaker_db : way.weaker_db;
    for (int64_t i = 0; i < of_bodies; i++)
        marks[bodies[i]] = false;
    for (int64_t p = 0; p < count; p++)
        if (is_by(way, pairs[p]))
            marks[pairs[p].echo] = true; /* it is no body then */
        else
            said.others++;
    for (int64_t i = 0, p = 0; i < of_bodies; i++) {
        const Received body = echoes[bodies[i]];
        bool shows = false;
        for (; p < count && pairs[p].body == bodies[i]; p++)
            shows |= is_by(way, pairs[p]) && fabs(body.level_db - echoes[pairs[p].echo].level_db - usual_db) <= SAME_DB;
        if (marks[bodies[i]])
            continue;
        said.shown += shows;
        said.expected += shows || (body.snr_db - usual_db >= way.from_db && body.near_m + way.later_m < way.far_m);
    }
    return said;
}

/* Whether so many bodies show a way that other pairs, over most_m of differences, do not let it be chance. */
static bool is_no_chance(Said said, double most_m)
{
    const double by_chance = (double)said.others * 2.0 * SAME_M / most_m, shown = (double)said.shown;
    return said.shown >= FEWEST && exp(shown * log(by_chance) - lgamma(shown + 1.0)) * most_m / (2.0 * SAME_M) < CHANCE;
}

/* Adds the echoes to those that were received. a_count: what a count of amplitude is worth, dB; 0: it is linear. */
static void add(const Echo *echoes, int64_t count, double a_count, Received *received)
{
    for (int64_t k = 0; k < count; k++) {
        const Echo *e = &echoes[k];
        const double level_db = a_count > 0.0 ? e->amplitude * a_count : 20.0 * log10(larger(e->amplitude, 1e-6));
        received[k] = (Received){e->near_m, e->near_m + e->range_extent_m, e->bearing_rad, e->snr_db, level_db};
    }
}

/* Lets votes (steps,), the share of the last pings that show a way longer by (k + 1) * step_m, rise and fall by such
   weights; returns the largest. Of a way that is reported, or beside one, a body is enough, and where none is to show it
   only `idle` of the vote is lost. a_count: of an echo's amplitude; weaker_db (steps,): by how much echoes are weaker. */
KERNEL_FLOAT(vote_for_ways, ECHO "[found] echoes, " ECHO "[few] faint, float a_count, float far_m, float from_db, "
                            "float step_m, float rise, float fall, float idle, b1[steps] reported, out f8[steps] votes, "
                            "out f8[steps] weaker_db")
{
    const int64_t count = SIZE(0, 0) + SIZE(1, 0), steps = SIZE(10, 0);
    const bool *reported = ARRAY(const bool, 9);
    double *votes = ARRAY(double, 10), *weaker_db = ARRAY(double, 11), largest = 0.0;
    int64_t bodies[MOST_BODIES];
    bool *marks = ZEROS(bool, count);
    Received *received = SCRATCH(Received, count);
    Pair *pairs = SCRATCH(Pair, MOST_BODIES * count);
    add(ARRAY(const Echo, 0), SIZE(0, 0), FLOAT(2), received);
    add(ARRAY(const Echo, 1), SIZE(1, 0), FLOAT(2), received + SIZE(0, 0));
    const int64_t of_bodies = find_bodies(received, count, bodies);
    const double most_m = (double)steps * FLOAT(5);
    const int64_t of_pairs = find_pairs(received, count, bodies, of_bodies, most_m, pairs);
    for (int64_t k = 0; k < steps; k++) {
        const bool known = reported[k] || (k > 0 && reported[k - 1]) || (k + 1 < steps && reported[k + 1]);
        const Way way = {(double)(k + 1) * FLOAT(5), reported[k] ? weaker_db[k] : NAN, FLOAT(3), FLOAT(4)};
        const Said said = said_by(received, bodies, of_bodies, pairs, of_pairs, way, marks);
        if ((known ? said.shown > 0 : is_no_chance(said, most_m)) && (double)said.shown >= SHARE * (double)said.expected) {
            votes[k] += FLOAT(6) * (1.0 - votes[k]);
            weaker_db[k] += (reported[k] ? FLOAT(6) : 1.0) * (said.weaker_db - weaker_db[k]);
        } else {
            votes[k] -= (reported[k] && said.expected == 0 ? FLOAT(8) : FLOAT(7)) * votes[k];
        }
        largest = larger(largest, votes[k]);
    }
    return largest;
}
