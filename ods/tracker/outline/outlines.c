/* Outlines of objects: what the echoes of images show of them, and circles that cover it (outlines.py). */

#include "ods/tracker/outline/seen.h"

/* ---------------------------------------------------------------- means over images */

/* `OutlineTable` in a signature: fourteen arguments; (n,) each. */
#define KNOWN                                                                                                           \
    "out f8[n] sights, out f8[n] unseen_s, out f8[n] near, out f8[n] near_variance, out f8[n] near_claim, "             \
    "out f8[n] along_claim, out f8[n] radius_claim, out f8[n] north, out f8[n] east, out f8[n] north_north, "           \
    "out f8[n] north_east, out f8[n] east_east, out f8[n] length, out f8[n] length_square"

typedef struct {
    double *sights, *unseen_s, *near, *near_variance, *near_claim, *along_claim, *radius_claim;
    double *means[7]; /* from `north` on */
} Known;

/* Returns the `OutlineTable` of the first fourteen arguments. */
static Known known_from(const Argument *arguments)
{
    return (Known){ARRAY(double, 0), ARRAY(double, 1), ARRAY(double, 2), ARRAY(double, 3),
                   ARRAY(double, 4), ARRAY(double, 5), ARRAY(double, 6),
                   {ARRAY(double, 7), ARRAY(double, 8), ARRAY(double, 9), ARRAY(double, 10), ARRAY(double, 11),
                    ARRAY(double, 12), ARRAY(double, 13)}};
}

static void move_mean(double *mean, double share, double value)
{
    *mean += share * (value - *mean);
}

/* Takes in the nearest of an object's echoes in an image. */
static void take_front(const Known *known, int64_t i, const Seen *seen, int64_t front, double share, double edge_kept_s)
{
    const double along = square(seen->sigma_along[front]), radius = square(seen->sigma_radius[front]);
    if (isfinite(radius)) {
        const double begins = known->radius_claim[i] == 0.0 ? 1.0 : share;
        move_mean(&known->along_claim[i], begins, along);
        move_mean(&known->radius_claim[i], begins, radius);
    }
    const bool is_fresh = known->sights[i] == 0.0 || known->unseen_s[i] > edge_kept_s;
    const double variance = square(seen->sigma_near[front]), before = known->near_variance[i];
    const double gain = is_fresh ? 1.0 : before / (before + variance);
    move_mean(&known->near[i], gain, seen->near[front]);
    known->near_variance[i] = gain * variance;
    move_mean(&known->near_claim[i], is_fresh ? 1.0 : share, variance);
}

/* What an object's echoes in one image add up to, weighted by their lengths. */
typedef struct {
    double weight, north, east, nn, ne, ee;
    int64_t front; /* the nearest of them; -1: there are none */
} Sum;

static void add_echo(Sum *sum, const Seen *seen, int64_t k)
{
    const double weight = larger(seen->length[k], 1e-3), north = seen->place[k][0], east = seen->place[k][1];
    sum->weight += weight;
    sum->north += weight * north;
    sum->east += weight * east;
    if (sum->front < 0 || seen->near[k] < seen->near[sum->front] || isnan(seen->near[sum->front]))
        sum->front = k;
}

static void add_moments(Sum *sum, const Seen *seen, int64_t k)
{
    const double weight = larger(seen->length[k], 1e-3), north = seen->place[k][0] - sum->north / sum->weight;
    const double east = seen->place[k][1] - sum->east / sum->weight;
    sum->nn += weight * (seen->extent[k][0][0] + north * north);
    sum->ne += weight * (seen->extent[k][0][1] + north * east);
    sum->ee += weight * (seen->extent[k][1][1] + east * east);
}

/* Takes in what the echoes of an image show of the objects that they are of. `least_share`: least weight of an image in
   the means. */
KERNEL(take_outlines, KNOWN ", f8[3,n] position, " SEEN ", i8[m] owner, float least_share, float edge_kept_s")
{
    const Known known = known_from(arguments);
    const int64_t n = SIZE(0, 0), *owner = ARRAY(int64_t, 24);
    const Seen seen = seen_from(arguments, 15);
    Sum *sums = SCRATCH(Sum, n);
    for (int64_t i = 0; i < n; i++)
        sums[i] = (Sum){.front = -1};
    for (int64_t k = 0; k < seen.m; k++)
        if (0 <= owner[k] && owner[k] < n)
            add_echo(&sums[owner[k]], &seen, k);
    for (int64_t k = 0; k < seen.m; k++)
        if (0 <= owner[k] && owner[k] < n)
            add_moments(&sums[owner[k]], &seen, k);
    for (int64_t i = 0; i < n; i++) {
        const Sum *sum = &sums[i];
        if (sum->front < 0)
            continue;
        const double share = larger(FLOAT(25), 1.0 / (known.sights[i] + 1.0));
        take_front(&known, i, &seen, sum->front, share, FLOAT(26));
        const double nn = sum->nn / sum->weight, ne = sum->ne / sum->weight, ee = sum->ee / sum->weight;
        const double half = sqrt(1.5 * (nn + ee) + 3.0 * hypot(0.5 * (nn - ee), ne));
        const double shown[7] = {sum->north / sum->weight - ARRAY(double, 14)[i],
                                 sum->east / sum->weight - ARRAY(double, 14)[n + i], nn, ne, ee, half, half * half};
        for (int mean = 0; mean < 7; mean++)
            move_mean(&known.means[mean][i], share, shown[mean]);
        known.sights[i] += 1.0;
        known.unseen_s[i] = 0.0;
    }
}

/* ---------------------------------------------------------------- strips */

/* The strip with the same second moments as an object: how likely it is elongated, half its length and width, m, its
   azimuth, and the standard deviation of its half length; all 0 of what was seen too few times. */
typedef struct {
    double elongated, half_length, half_width, azimuth, sigma;
} Strip;
_Static_assert(sizeof(Strip) == 5 * sizeof(double), "as in f8[n,5]");

/* What makes an object elongated: `MIN_IMAGES` and the like of outlines.py. */
typedef struct {
    double least_sights, from_m, ratio, length_error;
} Elongation;

static Strip strip_of(const Known *known, int64_t i, Elongation rule)
{
    const double nn = known->means[2][i], ne = known->means[3][i], ee = known->means[4][i], length = known->means[5][i];
    if (known->sights[i] < rule.least_sights)
        return (Strip){0};
    const double mean = 0.5 * (nn + ee), gap = hypot(0.5 * (nn - ee), ne), root3 = sqrt(3.0);
    const double half_length = root3 * sqrt(mean + gap), half_width = root3 * sqrt(larger(0.0, mean - gap));
    const double spread = sqrt(larger(0.0, known->means[6][i] - length * length));
    const double sigma = hypot(spread, rule.length_error * half_length) + 1e-3;
    const double excess = half_length - larger(rule.from_m, rule.ratio * half_width);
    const double azimuth = 0.5 * atan2(2.0 * ne, nn - ee), half_turn = 3.14159265358979323846;
    return (Strip){0.5 * erfc(-excess / sigma * sqrt(0.5)), half_length, half_width,
                   azimuth < 0.0 ? azimuth + half_turn : azimuth, sigma};
}

/* Sets the strips of objects. */
KERNEL(strips_of, KNOWN ", float least_sights, float from_m, float ratio, float length_error, out f8[n,5] strips")
{
    const Known known = known_from(arguments);
    for (int64_t i = 0; i < SIZE(0, 0); i++)
        ARRAY(Strip, 18)[i] = strip_of(&known, i, (Elongation){FLOAT(14), FLOAT(15), FLOAT(16), FLOAT(17)});
}

/* Makes circles cover the outlines of objects, `of` their numbers, -1: none, that are more `likely` elongated than not:
   at most `too_small` times as large; and adds what images have in common, a part `common` of what they claim. */
KERNEL(cover_outlines, KNOWN ", f8[n,5] strips, i8[objects] of, f8[3] head, f8[3,objects] position, float likely, "
                       "float too_small, float common, out f8[objects] radius, out f8[objects] covariance_ne, "
                       "out f8[3,objects] sigma_position, out f8[objects] sigma_radius")
{
    const Known known = known_from(arguments);
    const int64_t objects = SIZE(15, 0);
    const double *head = ARRAY(double, 16), *position = ARRAY(double, 17), common = square(FLOAT(20));
    for (int64_t k = 0; k < objects; k++) {
        const int64_t i = ARRAY(int64_t, 15)[k];
        if (i < 0 || i >= SIZE(0, 0))
            continue;
        const Strip *strip = &ARRAY(Strip, 14)[i];
        double *radius = &ARRAY(double, 21)[k], *sigma = ARRAY(double, 23);
        if (strip->elongated > FLOAT(18)) {
            const double reach = hypot(known.means[0][i], known.means[1][i]) + strip->half_length;
            *radius = larger(*radius, smaller(reach, FLOAT(19) * *radius));
        }
        const double north = position[k] - head[0], east = position[objects + k] - head[1];
        const double away = larger(hypot(north, east), 1e-3), along = common * known.along_claim[i] / (away * away);
        ARRAY(double, 22)[k] += along * north * east;
        sigma[k] = sqrt(square(sigma[k]) + along * north * north);
        sigma[objects + k] = sqrt(square(sigma[objects + k]) + along * east * east);
        ARRAY(double, 24)[k] = sqrt(square(ARRAY(double, 24)[k]) + common * known.radius_claim[i]);
    }
}
