/* Pulses at a train's places that no echo shows, from the images of the last pings: see buried_pulses.py. */

#include <float.h>

#include "ods/pipeline/image/samples/samples.h"

/* What is compared is so long in range, m: a pulse of 0.5 ms. */
#define WIDTH_M 0.4
/* Levels are known at so many places in a width. It begins one of them before where an echo seems to begin. */
#define PLACES 4
/* Excess, in standard deviations, of pulses that are found, which is the most that one place can show, and of those that
   are still received. */
#define FOUND 4.5
#define HEARD 2.0

/* Log amplitude of the last pings in one direction, mean of a width from each place on. */
typedef struct {
    const float *level; /* (pings, places) */
    const double *sent_s;
    int64_t pings, places;
    double first_s, place_s, width_s; /* times of arrival */
} Levels;

/* As in pulses.c. */
typedef struct {
    double period_s, at_s;
} Train;

/* What is the same at all places of a direction. */
typedef struct {
    int64_t apart; /* pings that are compared */
    double mean, spread;
} Background;

/* Returns how much later than `sent_s` the first of the train is. */
static double first_after(Train train, double sent_s)
{
    const double steps = (train.at_s - sent_s) / train.period_s;
    return (steps - floor(steps)) * train.period_s;
}

/* Returns how many pings later a train's places have moved by a width; beyond all pings if they do not. */
static int64_t pings_apart(const Levels *levels, double period_s)
{
    int64_t apart = 1;
    for (; apart < levels->pings; apart++) {
        const double moved_s = first_after((Train){period_s, levels->sent_s[0]}, levels->sent_s[apart]);
        if (smaller(moved_s, period_s - moved_s) >= levels->width_s)
            break;
    }
    return apart;
}

/* Returns by how much a train's places are brighter than so many pings before and after; NaN: not known. */
static double brighter(const Levels *levels, Train train, int64_t apart)
{
    double total = 0.0, count = 0.0;
    for (int64_t one = 0; one < levels->pings; one++)
        for (int64_t other = one - apart; other <= one + apart; other += 2 * apart) {
            if (other < 0 || other >= levels->pings)
                continue;
            double place = (first_after(train, levels->sent_s[one]) - levels->first_s) / levels->place_s;
            for (; place < (double)levels->places - 0.5; place += train.period_s / levels->place_s) {
                if (place < 0.0)
                    continue;
                const int64_t k = (int64_t)(place + 0.5);
                total += (double)(levels->level[one * levels->places + k] - levels->level[other * levels->places + k]);
                count += 1.0;
            }
        }
    return count > 0.0 ? total / count : NAN;
}

/* Returns what places show that are none of the train's. */
static Background background_of(const Levels *levels, Train train)
{
    const int64_t apart = pings_apart(levels, train.period_s);
    double n = 0.0, sum = 0.0, squares = 0.0;
    for (double later_s = levels->width_s; later_s < train.period_s - levels->width_s; later_s += levels->width_s) {
        const double found = brighter(levels, (Train){train.period_s, train.at_s + later_s}, apart);
        if (found == found)
            n += 1.0, sum += found, squares += square(found);
    }
    const double mean = n > 0.0 ? sum / n : 0.0;
    return (Background){apart, mean, n > 1.0 ? sqrt(larger(squares / n - square(mean), NOT_ZERO)) : INFINITY};
}

/* Returns the excess of the pulses at `count` parts of a period of so many pings, in standard deviations, but for those
   places where the train's own come in other pings. */
static double excess(const Levels *levels, Train train, int64_t count, int64_t pings, Background background)
{
    double n = 0.0, sum = 0.0;
    for (int64_t k = 1; k < count; k++) {
        if (k * pings % count == 0)
            continue;
        const double later_s = train.period_s * (double)k / (double)count;
        const double found = brighter(levels, (Train){train.period_s, train.at_s + later_s}, background.apart);
        if (found == found)
            n += 1.0, sum += smaller((found - background.mean) / background.spread, FOUND);
    }
    return n > 0.0 ? sum / sqrt(n) : 0.0;
}

/* Fills in a row of levels: of `beams` rows of samples together, each sample's amplitude by the table, if there is one. */
static void measure(Samples samples, int64_t row, int64_t beams, const float *table, int64_t width, int64_t step,
                    int64_t places, float *level)
{
    float *restrict sum = ZEROS(float, samples.samples), *restrict values = SCRATCH(float, samples.samples);
    for (int64_t b = 0; b < beams; b++) {
        load_samples(samples, row + b, 0, 1, samples.samples, values);
        for (int64_t k = 0; k < samples.samples; k++)
            sum[k] += table ? table[(int64_t)values[k]] : values[k];
    }
    for (int64_t p = 0; p < places; p++) {
        float all = 0.0f;
        for (int64_t k = p * step; k < p * step + width; k++)
            all += sum[k];
        level[p] = logf(all > 0.0f ? all : FLT_MIN);
    }
}

/* Returns how many pulses come in a train's period; 0: none, or no others than those known.

   frames: of each ping the samples of the same number of beams; table: their amplitudes by count, empty for linear ones;
   sent_s: as of the train; s_a_m: of time a metre of range; shortest_s: the shortest period that is looked for; is_known: whether those at the train's places are asked for. */
KERNEL_INT(pulses_a_period, "u1|u2|f4[rows,samples] frames, f4[:] table, f8[pings] sent_s, float s_a_m, float range0_m, "
                            "float dr_m, float period_s, float at_s, float shortest_s, bool is_known")
{
    const int64_t pings = SIZE(2, 0), beams = SIZE(0, 0) / larger_i(pings, 1);
    const int64_t width = larger_i((int64_t)(WIDTH_M / FLOAT(5) + 0.5), 1), step = larger_i(width / PLACES, 1);
    const int64_t places = (SIZE(0, 1) - width) / step;
    const float *table = SIZE(1, 0) > 0 ? ARRAY(const float, 1) : NULL;
    const Train train = {FLOAT(6), FLOAT(7) - WIDTH_M / PLACES * FLOAT(3)};
    if (pings < 2 || beams < 1 || places < 2 || !(train.period_s > 0.0))
        return 0;
    float *level = SCRATCH(float, pings * places);
    for (int64_t p = 0; p < pings; p++)
        measure(SAMPLES(0), p * beams, beams, table, width, step, places, level + p * places);
    const double *sent_s = ARRAY(const double, 2);
    const Levels levels = {level, sent_s, pings, places, FLOAT(4) * FLOAT(3), (double)step * FLOAT(5) * FLOAT(3),
                           WIDTH_M * FLOAT(3)};
    const Background background = background_of(&levels, train);
    if (BOOL(9)) {
        const double found = (brighter(&levels, train, background.apart) - background.mean) / background.spread;
        return found >= HEARD;
    }
    const int64_t of_period = (int64_t)(train.period_s / (sent_s[pings - 1] - sent_s[pings - 2]) + 0.5);
    double most = 0.0;
    int64_t best = 0;
    for (int64_t count = 2; (double)count * FLOAT(8) <= train.period_s; count++) {
        const double found = excess(&levels, train, count, larger_i(of_period, 1), background);
        if (found > most)
            most = found, best = count;
    }
    return most >= FOUND ? best : 0;
}
