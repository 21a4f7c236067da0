/* The period of another sonar's pulses, from the instants at which echoes arrived: see pulses.py. */

#include "kernel.h"

/* An arrival is one of a train when it is so near to its place, s. */
#define TOLERANCE_S 0.35e-3
/* Periods, s, that are sought. */
#define SHORTEST_S 0.02
#define LONGEST_S 1.0
/* A train has so many arrivals, in so many pings, so large a share of those that were to be heard, and so large a share
   of all that came since the first: others are there by chance. */
#define FEWEST 5
#define FEWEST_PINGS 3
#define HEARD_SHARE 0.7
#define OWN_SHARE 0.45
/* A body is no train: one place a ping, on a line over time to so many seconds of arrival, no faster than this share of
   the speed of sound there and back (15 m/s). */
#define LINE_S 0.3e-3
#define FASTEST 0.02

typedef struct {
    double at_s;
    double ping; /* number among those of the windows */
} Arrival;

/* When pings could hear. */
typedef struct {
    double begin_s, end_s;
} Window;

typedef struct {
    const Arrival *arrivals;
    const Window *windows;
    int64_t count, pings;
} Heard;

typedef struct {
    double period_s, at_s;
    int64_t matched;
} Train;

static bool is_of_train(Train train, double at_s)
{
    const double steps = (at_s - train.at_s) / train.period_s;
    return fabs(steps - rint(steps)) * train.period_s <= TOLERANCE_S;
}

/* Returns how many pulses were to be heard from the ping `from` on. */
static double expected(Heard heard, Train train, int64_t from)
{
    double count = 0.0;
    for (int64_t p = from; p < heard.pings; p++) {
        const double last = floor((heard.windows[p].end_s - train.at_s) / train.period_s);
        count += larger(last - ceil((heard.windows[p].begin_s - train.at_s) / train.period_s) + 1.0, 0.0);
    }
    return count;
}

/* Places of a train that were heard, in order of pings. */
typedef struct {
    int64_t count, pings, first; /* ping */
    bool one_a_ping;
} Places;

/* Fills kept with the arrivals of a train, of those at one place the first. */
static Places places_of(Heard heard, Train train, Arrival *kept)
{
    Places places = {0, 0, 0, true};
    double step_before = NAN, ping_before = -1.0;
    for (int64_t k = 0; k < heard.count; k++) {
        const Arrival a = heard.arrivals[k];
        const double step = rint((a.at_s - train.at_s) / train.period_s);
        if (!is_of_train(train, a.at_s) || (a.ping == ping_before && step == step_before))
            continue;
        places.one_a_ping &= a.ping != ping_before;
        places.pings += a.ping != ping_before;
        step_before = step, ping_before = a.ping;
        kept[places.count++] = a;
    }
    places.first = places.count > 0 ? (int64_t)kept[0].ping : 0;
    return places;
}

/* Whether arrivals, one a ping, are on a line: a body's. */
static bool is_line(Heard heard, const Arrival *arrivals, int64_t count)
{
    double n = (double)count, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, squares = 0.0;
    const double begun_s = heard.windows[0].begin_s;
    for (int64_t k = 0; k < count; k++) {
        const double sent_s = heard.windows[(int64_t)arrivals[k].ping].begin_s, t = sent_s - begun_s;
        x += t, y += arrivals[k].at_s - sent_s, xx += t * t, xy += t * (arrivals[k].at_s - sent_s);
    }
    const double spread = n * xx - x * x, slope = spread > 0.0 ? (n * xy - x * y) / spread : 0.0;
    for (int64_t k = 0; k < count; k++) {
        const double sent_s = heard.windows[(int64_t)arrivals[k].ping].begin_s;
        squares += square(arrivals[k].at_s - sent_s - (y - slope * x) / n - slope * (sent_s - begun_s));
    }
    return fabs(slope) <= FASTEST && squares <= n * square(LINE_S);
}

/* Returns the train with the number of its places that were heard; 0 where it is no train. kept: work space. */
static Train judged(Heard heard, Train train, Arrival *kept)
{
    const double reach = TOLERANCE_S / train.period_s, rate = 1.0 / train.period_s;
    int64_t near = 0;
    for (int64_t k = 0; k < heard.count; k++) {
        const double steps = (heard.arrivals[k].at_s - train.at_s) * rate;
        near += fabs(steps - rint(steps)) <= reach;
    }
    if (near < FEWEST) /* as nearly always */
        return train;
    const Places places = places_of(heard, train, kept);
    if (places.count < FEWEST || places.pings < FEWEST_PINGS)
        return train;
    if ((double)places.count < HEARD_SHARE * expected(heard, train, places.first))
        return train;
    int64_t since = 0;
    for (int64_t k = 0; k < heard.count; k++)
        since += heard.arrivals[k].ping >= (double)places.first;
    if ((double)places.count < OWN_SHARE * (double)since)
        return train;
    train.matched = places.one_a_ping && is_line(heard, kept, places.count) ? 0 : places.count;
    return train;
}

/* Returns the train with its period and place by least squares. */
static Train fitted(Heard heard, Train train)
{
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int64_t k = 0; k < heard.count; k++)
        if (is_of_train(train, heard.arrivals[k].at_s)) {
            const double late = heard.arrivals[k].at_s - train.at_s, steps = rint(late / train.period_s);
            n += 1.0, x += steps, y += late, xx += steps * steps, xy += steps * late;
        }
    const double spread = n * xx - x * x;
    if (spread > 0.0) {
        train.period_s = (n * xy - x * y) / spread;
        train.at_s += (y - train.period_s * x) / n;
    }
    return train;
}

/* An echo. */
typedef struct {
    double near_m, bearing_rad, extent_rad;
} Echo;

/* Notes which echoes have none of those of the ping before so near in range and, beside their extents, in bearing. */
KERNEL(without_forerunner, "f8[now,3] echoes, f8[before,3] forerunners, float reach_m, float reach_rad, out b1[now] alone")
{
    const Echo *echoes = ARRAY(const Echo, 0), *forerunners = ARRAY(const Echo, 1);
    for (int64_t i = 0; i < SIZE(0, 0); i++) {
        bool found = false;
        for (int64_t k = 0; k < SIZE(1, 0) && !found; k++) {
            const double beside_rad = 0.5 * (echoes[i].extent_rad + forerunners[k].extent_rad);
            found = fabs(echoes[i].near_m - forerunners[k].near_m) <= FLOAT(2)
                    && fabs(echoes[i].bearing_rad - forerunners[k].bearing_rad) <= FLOAT(3) + beside_rad;
        }
        ARRAY(bool, 4)[i] = !found;
    }
}

/* Finds the train that explains most arrivals, in order of pings, the last one among them: fills train with its period
   and the time of a pulse, s; tells whether there is one. */
KERNEL_BOOL(find_train, "f8[count,2] arrivals, f8[pings,2] windows, out f8[2] train")
{
    const Heard heard = {ARRAY(const Arrival, 0), ARRAY(const Window, 1), SIZE(0, 0), SIZE(1, 0)};
    Train best = {0.0, 0.0, 0};
    Arrival *kept = SCRATCH(Arrival, heard.count);
    for (int64_t k = 0; k < heard.count; k++)
        if (!(heard.arrivals[k].ping >= 0.0 && heard.arrivals[k].ping < (double)heard.pings))
            return false;
    for (int64_t i = 0; i < heard.count - 1; i++) {
        const double last_s = heard.arrivals[heard.count - 1].at_s, apart_s = fabs(last_s - heard.arrivals[i].at_s);
        for (double n = 1.0; apart_s / n >= SHORTEST_S; n += 1.0) {
            const Train found = judged(heard, (Train){apart_s / n, last_s, 0}, kept);
            if (apart_s / n <= LONGEST_S && found.matched > best.matched)
                best = found;
        }
    }
    if (best.matched == 0)
        return false;
    best = fitted(heard, best);
    ARRAY(double, 2)[0] = best.period_s;
    ARRAY(double, 2)[1] = best.at_s;
    return true;
}
