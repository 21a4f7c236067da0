/* Echoes as the head would have measured them, and which of them is of which object (seen.py, owners.py). */

#include "ods/tracker/outline/seen.h"

/* ---------------------------------------------------------------- echoes */

/* Columns of an echo: what `seen_from` takes of a detection. */
enum { RANGE, BEARING, ELEVATION, RADIUS, SIGMA_RANGE, SIGMA_BEARING, NEAR, SIGMA_NEAR, LENGTH, WIDTH, AXIS, OF_RADIUS, TAKEN };
_Static_assert(TAKEN == 12, "as in see_outlines");

typedef double TurnRow[3];

/* Sets `GlobalEchoes` of seen.py to echoes as a head at `position`, turned by `turned` to the global frame, sees them
   that moves by `velocity` and turns by `fan_turn` rad/m while they come. `sound_speed`: infinite where all come at
   once. */
KERNEL(see_outlines, "f8[m,12] echoes, f8[3] position, f8[3,3] turned, f8[3] velocity, float fan_turn, float sound_speed, "
                     "out f8[m,2] place, out f8[m] radius, out f8[m] sigma, out f8[m] near, out f8[m] sigma_near, "
                     "out f8[m] sigma_along, out f8[m] sigma_radius, out f8[m,2,2] extent, out f8[m] length")
{
    const double *position = ARRAY(double, 1), *velocity = ARRAY(double, 3);
    const TurnRow *turned = ARRAY(const TurnRow, 2);
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        const double *echo = ARRAY(const double, 0) + TAKEN * k;
        const double range = echo[RANGE], bearing = echo[BEARING] + FLOAT(4) * range, level = cos(echo[ELEVATION]);
        const double body[3] = {level * cos(bearing), level * sin(bearing), -sin(echo[ELEVATION])};
        double sight[3];
        for (int i = 0; i < 3; i++)
            sight[i] = turned[i][0] * body[0] + turned[i][1] * body[1] + turned[i][2] * body[2];
        const double closing = sight[0] * velocity[0] + sight[1] * velocity[1] + sight[2] * velocity[2];
        const double moved = range / FLOAT(5) * closing;
        for (int i = 0; i < 2; i++)
            ARRAY(Pair, 6)[k][i] = position[i] + (range + moved) * sight[i];
        const double azimuth = atan2(sight[1], sight[0]) + echo[AXIS], c = cos(azimuth), s = sin(azimuth);
        const double both = (square(echo[LENGTH]) + square(echo[WIDTH])) / 6.0;
        const double gap = (square(echo[LENGTH]) - square(echo[WIDTH])) / 6.0;
        Moments *extent = &ARRAY(Moments, 13)[k];
        (*extent)[0][0] = both + gap * (c * c - s * s);
        (*extent)[1][1] = both - gap * (c * c - s * s);
        (*extent)[0][1] = (*extent)[1][0] = 2.0 * gap * c * s;
        ARRAY(double, 7)[k] = echo[RADIUS];
        ARRAY(double, 8)[k] = larger(echo[SIGMA_RANGE], range * echo[SIGMA_BEARING]);
        ARRAY(double, 9)[k] = echo[NEAR] + moved;
        ARRAY(double, 10)[k] = echo[SIGMA_NEAR];
        ARRAY(double, 11)[k] = isnan(echo[OF_RADIUS]) ? NAN : echo[SIGMA_RANGE];
        ARRAY(double, 12)[k] = echo[OF_RADIUS];
        ARRAY(double, 14)[k] = echo[LENGTH];
    }
}

/* ---------------------------------------------------------------- owners */

/* n objects; `live`: seen in this image. `extended`: they have an outline, with the middle so far from the object's place
   and these second moments about it; others are round, as far as is known yet. */
typedef struct {
    int64_t n;
    const bool *live, *extended;
    const double *position, *sigma_position, *radius, *sigma_radius; /* vectors (3, n) */
    const double *north, *east, *north_north, *north_east, *east_east;
} Objects;

/* What an echo may be off: `GATE` and the like of owners.py. */
typedef struct {
    double axes, sigmas, m;
} Gate;

/* Returns how badly an echo fits an object: a squared distance in axes of its ellipse, and the logarithm of that one's
   area; infinite where it is not of it. */
static double misfit(const Objects *objects, int64_t i, const Seen *seen, int64_t k, Gate gate, double *away)
{
    const double radius = objects->radius[i], north = seen->place[k][0] - objects->position[i];
    const double east = seen->place[k][1] - objects->position[objects->n + i];
    const double sigma = larger(objects->sigma_position[i], objects->sigma_position[objects->n + i]);
    const double blur = hypot(gate.sigmas * hypot(sigma, seen->sigma[k]), gate.m);
    const double largest = 2.0 * (radius + gate.sigmas * objects->sigma_radius[i]) + gate.m;
    if (!(hypot(north, east) <= radius + gate.axes * blur) || !(seen->radius[k] <= largest))
        return INFINITY;
    double nn = square(radius), ne = 0.0, ee = nn;
    if (objects->extended[i]) {
        nn = 3.0 * (objects->north_north[i] + square(objects->north[i]));
        ne = 3.0 * (objects->north_east[i] + objects->north[i] * objects->east[i]);
        ee = 3.0 * (objects->east_east[i] + square(objects->east[i]));
    }
    nn += square(blur);
    ee += square(blur);
    const double area = nn * ee - ne * ne;
    *away = (ee * north * north - 2.0 * ne * north * east + nn * east * east) / area;
    return *away + log(area);
}

/* Sets `owner` to the object that each echo is of, -1: none. Objects: `live`, `extended`, four arrays of `Snapshot`, and
   five of `OutlineTable`. */
KERNEL(owners_of, "b1[n] live, b1[n] extended, f8[3,n] position, f8[3,n] sigma_position, f8[n] radius, f8[n] sigma_radius, "
                  "f8[n] north, f8[n] east, f8[n] north_north, f8[n] north_east, f8[n] east_east, " SEEN ", "
                  "float axes, float sigmas, float m, out i8[m] owner")
{
    const Objects objects = {SIZE(0, 0),       ARRAY(bool, 0),   ARRAY(bool, 1),   ARRAY(double, 2),
                             ARRAY(double, 3), ARRAY(double, 4), ARRAY(double, 5), ARRAY(double, 6),
                             ARRAY(double, 7), ARRAY(double, 8), ARRAY(double, 9), ARRAY(double, 10)};
    const Seen seen = seen_from(arguments, 11);
    const Gate gate = {FLOAT(20), FLOAT(21), FLOAT(22)};
    for (int64_t k = 0; k < seen.m; k++) {
        double best = INFINITY, nearest = INFINITY;
        int64_t *owner = &ARRAY(int64_t, 23)[k];
        *owner = -1;
        for (int64_t i = 0; i < objects.n; i++) {
            double away = INFINITY;
            const double fit = objects.live[i] ? misfit(&objects, i, &seen, k, gate, &away) : INFINITY;
            if (fit < best) {
                best = fit;
                nearest = away;
                *owner = i;
            }
        }
        if (!(nearest <= square(gate.axes)))
            *owner = -1;
    }
}
