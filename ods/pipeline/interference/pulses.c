/* The period of another sonar's pulses, from the instants at which echoes arrived: see pulses.py. */

#include "ods/pipeline/measure/echo.h"

/* An arrival is one of a train, and a place one of a line, when it is so near to it, s. */
#define TOLERANCE_S 0.35e-3
/* The longest period, s, that is sought. */
#define LONGEST_S 1.0
/* A train has so many arrivals, in so many pings, so large a share of those that were to be received, and so large a share
   of all that came since the first: others are there by chance. */
#define FEWEST 5
/* Of a line, which has one a ping, so many: pulses whose period is near our own or a fraction of it, of which one a ping
   is loud enough, or a body. */
#define FEWEST_PINGS 3
#define HEARD_SHARE 0.7
#define OWN_SHARE 0.45
/* A body is no train: one place a ping, on a line over time, no faster than this share of the speed of sound there and
   back (15 m/s). */
#define FASTEST 0.02

/* Arrivals in one direction that are held against a period. */
#define MOST_ARRIVALS 24
/* So near in bearing, beside the echoes' own widths, are those of one source. */
#define SAME_RAD 0.07
/* What moves no faster than this has a forerunner, m/s. */
#define SLOW 3.0
/* Pulses of sonars are no longer than this, in range, m. */
#define LONGEST_M 2.0

/* Times are since a fixed instant. */
typedef struct {
    double at_s, bearing_rad, half_width_rad;
} Arrival;

/* One ping: when it received its nearest sample and its farthest, and its echoes that had no forerunner. */
typedef struct {
    double begin_s, end_s, count;
} Look;

typedef struct {
    double period_s, at_s; /* at_s: of a pulse */
    double bearing_rad, received_s;
    double buried; /* pulses a period of what was found, as buried_pulses.py received; 0: a line, if it is alone */
    double arrivals;
} Train;

/* An echo of the ping before. */
typedef struct {
    double near_m, bearing_rad, half_width_rad;
} Place;

/* What is remembered of the pings before: `PulseMemory` of pulses.py. */
typedef struct {
    int64_t *looks, *trains, *before;
    Look *look;        /* (pings,), the newest last */
    Arrival *arrivals; /* (pings, most_new): of each ping those that had no forerunner, the loudest */
    Train *train;      /* (most_trains,) */
    Place *place;      /* (most_before,) */
    int64_t pings, most_new, most_before;
} Memory;

#define MEMORY                                                                                                          \
    "out i8[3] counts, out f8[pings,3] looks, out f8[pings,most_new,3] arrivals, out f8[most_trains,6] trains, "         \
    "out f8[most_before,3] places"
#define MEMORY_AT(k)                                                                                                    \
    ((Memory){ARRAY(int64_t, k), ARRAY(int64_t, k) + 1, ARRAY(int64_t, k) + 2, ARRAY(Look, (k) + 1),                     \
              ARRAY(Arrival, (k) + 2), ARRAY(Train, (k) + 3), ARRAY(Place, (k) + 4), SIZE((k) + 2, 0), SIZE((k) + 2, 1),  \
              SIZE((k) + 4, 0)})

/* Arrivals from one direction, in order of time. */
typedef struct {
    double at_s[MOST_ARRIVALS];
    int64_t ping[MOST_ARRIVALS]; /* of the memory's */
    int64_t count, pings;
    const Look *look;
} Received;

/* A train that may be one; `line`: or a body. */
typedef struct {
    double period_s, at_s;
    int64_t matched;
    bool line;
} Guess;

static bool is_of(Guess guess, double at_s)
{
    const double steps = (at_s - guess.at_s) / guess.period_s;
    return fabs(steps - rint(steps)) * guess.period_s <= TOLERANCE_S;
}

/* Returns how many pulses were to be received from the ping `from` on. */
static double expected(const Received *received, Guess guess, int64_t from)
{
    double count = 0.0;
    for (int64_t p = from; p < received->pings; p++) {
        const double last = floor((received->look[p].end_s - guess.at_s) / guess.period_s);
        count += larger(last - ceil((received->look[p].begin_s - guess.at_s) / guess.period_s) + 1.0, 0.0);
    }
    return count;
}

/* Places of a train that were received, in order of time. */
typedef struct {
    int64_t kept[MOST_ARRIVALS]; /* of what was received, of those at one place the first */
    int64_t count, pings;
    bool one_a_ping;
} Places;

static Places places_of(const Received *received, Guess guess)
{
    Places places = {.one_a_ping = true};
    double step_before = NAN;
    int64_t ping_before = -1;
    for (int64_t k = 0; k < received->count; k++) {
        const double step = rint((received->at_s[k] - guess.at_s) / guess.period_s);
        const int64_t ping = received->ping[k];
        if (!is_of(guess, received->at_s[k]) || (ping == ping_before && step == step_before))
            continue;
        places.one_a_ping &= ping != ping_before;
        places.pings += ping != ping_before;
        step_before = step, ping_before = ping;
        places.kept[places.count++] = k;
    }
    return places;
}

/* Whether arrivals, one a ping, are on a line: a body's. */
static bool is_line(const Received *received, const Places *places)
{
    double n = (double)places->count, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, squares = 0.0;
    const double begun_s = received->look[0].begin_s;
    for (int64_t i = 0; i < places->count; i++) {
        const int64_t k = places->kept[i];
        const double sent_s = received->look[received->ping[k]].begin_s, t = sent_s - begun_s, late = received->at_s[k] - sent_s;
        x += t, y += late, xx += t * t, xy += t * late;
    }
    const double spread = n * xx - x * x, slope = spread > 0.0 ? (n * xy - x * y) / spread : 0.0;
    for (int64_t i = 0; i < places->count; i++) {
        const int64_t k = places->kept[i];
        const double sent_s = received->look[received->ping[k]].begin_s;
        squares += square(received->at_s[k] - sent_s - (y - slope * x) / n - slope * (sent_s - begun_s));
    }
    return fabs(slope) <= FASTEST && squares <= n * square(TOLERANCE_S);
}

/* Returns how many of what was received, so much later each than a pulse, s, may be pulses of a period. Float32 will do,
   and is fast: nearly always they are too few. */
static int32_t count_near(const float *later_s, int64_t count, double period_s)
{
    const float rate = (float)(1.0 / period_s), reach = (float)(1.01 * TOLERANCE_S / period_s);
    int32_t near = 0;
    for (int64_t k = 0; k < count; k++) {
        const float steps = later_s[k] * rate;
        near += fabsf(steps - rintf(steps)) <= reach;
    }
    return near;
}

/* Returns the guess with the number of its places that were received; 0 where it is no train. */
static Guess judged(const Received *received, Guess guess)
{
    int64_t since = 0;
    const Places places = places_of(received, guess);
    guess.line = places.one_a_ping && is_line(received, &places);
    if (places.count < (guess.line ? FEWEST_PINGS : FEWEST) || places.pings < FEWEST_PINGS)
        return guess;
    const int64_t first = received->ping[places.kept[0]];
    if ((double)places.count < HEARD_SHARE * expected(received, guess, first))
        return guess;
    for (int64_t k = 0; k < received->count; k++)
        since += received->ping[k] >= first;
    if ((double)places.count < OWN_SHARE * (double)since)
        return guess;
    guess.matched = places.count;
    return guess;
}

/* Returns the guess with period and place by least squares. */
static Guess fitted(const Received *received, Guess guess)
{
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int64_t k = 0; k < received->count; k++)
        if (is_of(guess, received->at_s[k])) {
            const double late = received->at_s[k] - guess.at_s, steps = rint(late / guess.period_s);
            n += 1.0, x += steps, y += late, xx += steps * steps, xy += steps * late;
        }
    const double spread = n * xx - x * x;
    if (spread > 0.0) {
        guess.period_s = (n * xy - x * y) / spread;
        guess.at_s += (y - guess.period_s * x) / n;
    }
    return guess;
}

static bool is_better(Guess a, Guess b)
{
    return a.line == b.line ? a.matched > b.matched : b.line && a.matched > 0;
}

/* Returns the train that explains most arrivals, the one at `at_s` among them, or else a line; none has `matched` 0. */
static Guess find_train(const Received *received, double at_s, double shortest_s)
{
    Guess best = {.line = true};
    float later_s[MOST_ARRIVALS];
    for (int64_t i = 0; i < received->count; i++)
        later_s[i] = (float)(received->at_s[i] - at_s);
    for (int64_t i = 0; i < received->count && received->count >= FEWEST_PINGS; i++) {
        const double apart_s = fabs(at_s - received->at_s[i]);
        for (double n = larger(1.0, ceil(apart_s / LONGEST_S)); apart_s / n >= shortest_s; n += 1.0) {
            if (count_near(later_s, received->count, apart_s / n) < FEWEST_PINGS)
                continue;
            const Guess guess = judged(received, (Guess){apart_s / n, at_s, 0, false});
            if (is_better(guess, best))
                best = guess;
        }
    }
    return best.matched > 0 ? fitted(received, best) : best;
}

/* Returns what was received from the direction of the arrival, the last so many. */
static Received heard_from(Memory memory, Arrival arrival)
{
    Received received = {.look = memory.look, .pings = *memory.looks};
    for (int64_t p = received.pings - 1; p >= 0; p--)
        for (int64_t k = 0; k < (int64_t)memory.look[p].count && received.count < MOST_ARRIVALS; k++) {
            const Arrival other = memory.arrivals[p * memory.most_new + k];
            const double beside_rad = arrival.half_width_rad + other.half_width_rad;
            if (!(fabs(arrival.bearing_rad - other.bearing_rad) <= SAME_RAD + beside_rad))
                continue;
            int64_t place = received.count++;
            for (; place > 0 && received.at_s[place - 1] > other.at_s; place--) {
                received.at_s[place] = received.at_s[place - 1];
                received.ping[place] = received.ping[place - 1];
            }
            received.at_s[place] = other.at_s, received.ping[place] = p;
        }
    return received;
}

static bool is_pulse_of(Train train, Arrival arrival)
{
    if (!(fabs(arrival.bearing_rad - train.bearing_rad) <= SAME_RAD + arrival.half_width_rad))
        return false;
    const double steps = (arrival.at_s - train.at_s) / train.period_s;
    return fabs(steps - rint(steps)) * train.period_s <= TOLERANCE_S;
}

static bool is_pulse(Memory memory, Arrival arrival)
{
    for (int64_t t = 0; t < *memory.trains; t++)
        if (is_pulse_of(memory.train[t], arrival))
            return true;
    return false;
}

/* Lets the trains follow an arrival that is theirs, as a line through the last ones, as many as pings are remembered. */
static void follow(Memory memory, Arrival arrival, double now_s)
{
    for (int64_t t = 0; t < *memory.trains; t++) {
        Train *train = &memory.train[t];
        if (!is_pulse_of(*train, arrival))
            continue;
        const double steps = rint((arrival.at_s - train->at_s) / train->period_s);
        const double error_s = arrival.at_s - train->at_s - steps * train->period_s;
        const double n = train->arrivals = smaller(train->arrivals + 1.0, (double)memory.pings), all = n * (n + 1.0);
        train->at_s += steps * train->period_s + (4.0 * n - 2.0) / all * error_s;
        train->period_s += 6.0 / all * error_s / larger(steps, 1.0);
        train->bearing_rad = arrival.bearing_rad;
        train->received_s = train->buried > 1.0 ? train->received_s : now_s;
    }
}

/* Forgets the trains that were not received for so long. */
static void forget_trains(Memory memory, double now_s, double longest_s)
{
    int64_t left = 0;
    for (int64_t t = 0; t < *memory.trains; t++)
        if (now_s - memory.train[t].received_s < longest_s)
            memory.train[left++] = memory.train[t];
    *memory.trains = left;
}

/* Begins the next ping; returns it. */
static Look *next_look(Memory memory, double begin_s, double end_s)
{
    if (*memory.looks == memory.pings) {
        const size_t kept = (size_t)memory.pings - 1;
        memmove(memory.look, memory.look + 1, kept * sizeof(Look));
        memmove(memory.arrivals, memory.arrivals + memory.most_new, kept * (size_t)memory.most_new * sizeof(Arrival));
        --*memory.looks;
    }
    Look *look = &memory.look[(*memory.looks)++];
    *look = (Look){begin_s, end_s, 0.0};
    return look;
}

/* Whether an echo has none of those of the ping before so near in range and, beside their extents, in bearing. */
static bool is_new(Memory memory, const Echo *echo, double reach_m)
{
    for (int64_t k = 0; k < *memory.before; k++) {
        const Place place = memory.place[k];
        const double beside_rad = place.half_width_rad + 0.5 * echo->bearing_extent_rad;
        if (fabs(echo->near_m - place.near_m) <= reach_m
            && fabs(echo->bearing_rad - place.bearing_rad) <= SAME_RAD + beside_rad)
            return false;
    }
    return true;
}

/* When a ping was sent, s since a fixed instant, and how much later a metre of range is received. */
typedef struct {
    double sent_s, s_a_m;
} Ping;

static Arrival arrival_of(const Echo *echo, Ping ping)
{
    return (Arrival){ping.sent_s + echo->near_m * ping.s_a_m, echo->bearing_rad, 0.5 * echo->bearing_extent_rad};
}

/* Fills new with the echoes that may be pulses, the loudest first; returns how many there are. */
static int64_t find_new(Memory memory, const Echo *echoes, int64_t count, double reach_m, Ping ping, Arrival *new)
{
    double *snr_db = SCRATCH(double, memory.most_new);
    int64_t found = 0;
    for (int64_t k = 0; k < count; k++) {
        const bool fits = found < memory.most_new || echoes[k].snr_db > snr_db[found - 1];
        if (!fits || echoes[k].range_extent_m > LONGEST_M || !is_new(memory, &echoes[k], reach_m))
            continue;
        int64_t place = found < memory.most_new ? found++ : found - 1;
        for (; place > 0 && snr_db[place - 1] < echoes[k].snr_db; place--) {
            snr_db[place] = snr_db[place - 1];
            new[place] = new[place - 1];
        }
        snr_db[place] = echoes[k].snr_db;
        new[place] = arrival_of(&echoes[k], ping);
    }
    return found;
}

static void remember(Memory memory, const Echo *echoes, int64_t count)
{
    *memory.before = smaller_i(count, memory.most_before);
    for (int64_t k = 0; k < *memory.before; k++)
        memory.place[k] = (Place){echoes[k].near_m, echoes[k].bearing_rad, 0.5 * echoes[k].bearing_extent_rad};
}

/* Looks for trains that new echoes are part of; fills them in, and returns how many there are. Only of `most` of the
   loudest ones: a train that lasts is found a ping later. */
static int64_t seek_trains(Memory memory, Look *look, const Arrival *new, int64_t count, double shortest_s, int64_t most,
                           Train *found)
{
    Arrival *kept = memory.arrivals + (look - memory.look) * memory.most_new;
    int64_t sought = 0, left = 0, trains = 0;
    for (int64_t k = 0; k < count; k++) {
        if (is_pulse(memory, new[k]))
            continue;
        kept[left++] = new[k];
        look->count = (double)left;
        if (sought++ >= most)
            continue;
        const Received received = heard_from(memory, new[k]);
        const Guess guess = find_train(&received, new[k].at_s, shortest_s);
        if (guess.matched > 0)
            found[trains++] = (Train){guess.period_s, guess.at_s, new[k].bearing_rad, look->end_s,
                                      guess.line ? 0.0 : 1.0, (double)guess.matched};
    }
    return trains;
}

static int64_t mark(Memory memory, const Echo *echoes, int64_t count, Ping ping, bool *marks)
{
    int64_t marked = 0;
    for (int64_t k = 0; k < count; k++)
        marked += marks[k] = is_pulse(memory, arrival_of(&echoes[k], ping));
    return marked;
}

/* Lets trains follow a ping's echoes, and looks for others; returns how many it filled in. sent_s: when it
   was sent, s since a fixed instant; s_a_m: of time a metre of range; since_s: since the ping before; shortest_s: the shortest
   period that is sought. */
KERNEL_INT(find_pulses, ECHO "[found] echoes, float sent_s, float s_a_m, float near_m, float far_m, float since_s, "
                             "float shortest_s, float longest_gap_s, " MEMORY ", out f8[most_found,6] found")
{
    const Echo *echoes = ARRAY(const Echo, 0);
    const int64_t count = SIZE(0, 0);
    const Ping ping = {FLOAT(1), FLOAT(2)};
    const Memory memory = MEMORY_AT(8);
    Look *look = next_look(memory, ping.sent_s + FLOAT(3) * ping.s_a_m, ping.sent_s + FLOAT(4) * ping.s_a_m);
    Arrival *new = SCRATCH(Arrival, memory.most_new);
    const int64_t of_new = find_new(memory, echoes, count, SLOW * FLOAT(5), ping, new);
    remember(memory, echoes, count);
    for (int64_t k = 0; k < count && *memory.trains > 0; k++)
        follow(memory, arrival_of(&echoes[k], ping), look->end_s);
    forget_trains(memory, look->end_s, FLOAT(7));
    return seek_trains(memory, look, new, of_new, FLOAT(6), SIZE(13, 0), ARRAY(Train, 13));
}

/* Marks which echoes of a ping, and which of its faint ones, are pulses; returns how many. */
KERNEL_INT(mark_pulses, ECHO "[found] echoes, " ECHO "[few] faint, float sent_s, float s_a_m, " MEMORY
                             ", out b1[found] of_echoes, out b1[few] of_faint")
{
    const Ping ping = {FLOAT(2), FLOAT(3)};
    const Memory memory = MEMORY_AT(4);
    if (*memory.trains == 0)
        return 0;
    return mark(memory, ARRAY(const Echo, 0), SIZE(0, 0), ping, ARRAY(bool, 9)) +
           mark(memory, ARRAY(const Echo, 1), SIZE(1, 0), ping, ARRAY(bool, 10));
}
