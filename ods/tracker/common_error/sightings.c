/* Echoes of tracked objects, and by how much each common error moves them (sightings.py). */

#include "kernel.h"

/* Columns of a design, as in sightings.py. */
enum { NORTH_OF_OBJECT, EAST_OF_OBJECT, NEARER, DEPTH, YAW, TURN, SCALE, LATENCY, NORTH, EAST, COLUMNS };
_Static_assert(COLUMNS == 10, "as in common_designs");

/* North and east. */
typedef double Flat[2];
typedef double TurnRow[3];
typedef double Design[2][COLUMNS];
typedef double Whitening[2][2];

/* Sets by how much each unknown moves a place that is `offset`, m, from a head of this velocity and rate of yaw. */
static void set_design(const Flat offset, const double *velocity, double yaw_rate, Design *design)
{
    const double away = hypot(offset[0], offset[1]), turned[2] = {-offset[1], offset[0]};
    memset(design, 0, sizeof *design);
    for (int axis = 0; axis < 2; axis++) {
        double *row = (*design)[axis];
        row[axis] = 1.0;
        row[NEARER] = -offset[axis] / away;
        row[DEPTH] = offset[axis] / (2.0 * away * away);
        row[YAW] = turned[axis];
        row[SCALE] = offset[axis];
        row[LATENCY] = velocity[axis] + yaw_rate * turned[axis];
    }
}

/* Sets the designs of places, see `design_of`. */
KERNEL(common_designs, "f8[k,2] offset, f8[2] velocity, float yaw_rate, out f8[k,2,10] design")
{
    for (int64_t k = 0; k < SIZE(0, 0); k++)
        set_design(ARRAY(Flat, 0)[k], ARRAY(double, 1), FLOAT(2), &ARRAY(Design, 3)[k]);
}

/* Sets `out` to the place of an echo from the head, as if it were level with it. */
static void set_offset(const TurnRow *turned, double range, double bearing, double *out)
{
    const double c = cos(bearing), s = sin(bearing);
    const double north = turned[0][0] * c + turned[0][1] * s, east = turned[1][0] * c + turned[1][1] * s;
    const double scale = range / larger(hypot(north, east), 1e-6);
    out[0] = north * scale;
    out[1] = east * scale;
}

/* Sets, of the `judged` of n objects that have an echo within `reach_m` of their edges, which these are; the place of the
   nearest echo, the design there, and what makes its errors, `least_m` and `least_rad` at least, independent and of
   variance 1. Returns how many. */
KERNEL_INT(common_sightings,
           "b1[n] judged, f8[3,n] position, f8[n] radius, f8[m] range_m, f8[m] bearing, f8[m] sigma_range, "
           "f8[m] sigma_bearing, f8[3] head, f8[3,3] turned, f8[2] velocity, float yaw_rate, float reach_m, "
           "float least_m, float least_rad, out i8[n] which, out f8[n,2] place, out f8[n,2,10] design, "
           "out f8[n,2,2] whitening")
{
    const int64_t n = SIZE(0, 0), m = SIZE(3, 0);
    const double *position = ARRAY(double, 1), *head = ARRAY(double, 7);
    Flat *offset = SCRATCH(Flat, m);
    int64_t count = 0;
    for (int64_t k = 0; k < m; k++)
        set_offset(ARRAY(const TurnRow, 8), ARRAY(double, 3)[k], ARRAY(double, 4)[k], offset[k]);
    for (int64_t i = 0; i < n; i++) {
        const double north = position[i] - head[0], east = position[n + i] - head[1];
        double nearest = INFINITY;
        int64_t own = -1;
        for (int64_t k = 0; k < m && ARRAY(bool, 0)[i]; k++) {
            const double off = hypot(offset[k][0] - north, offset[k][1] - east);
            if (off < nearest) {
                nearest = off;
                own = k;
            }
        }
        if (own < 0 || !(nearest < FLOAT(11) + ARRAY(double, 2)[i]))
            continue;
        const double *there = offset[own], away = hypot(there[0], there[1]);
        const double along = larger(ARRAY(double, 5)[own], FLOAT(12)) * away;
        const double across = larger(ARRAY(double, 6)[own], FLOAT(13)) * away * away;
        Whitening *white = &ARRAY(Whitening, 17)[count];
        (*white)[0][0] = there[0] / along;
        (*white)[0][1] = there[1] / along;
        (*white)[1][0] = -there[1] / across;
        (*white)[1][1] = there[0] / across;
        /* by the place tracked, as that of an echo has an error of its own: with it, estimates would be too small */
        set_design((const Flat){north, east}, ARRAY(double, 9), FLOAT(10), &ARRAY(Design, 16)[count]);
        for (int axis = 0; axis < 2; axis++)
            ARRAY(Flat, 15)[count][axis] = head[axis] + there[axis];
        ARRAY(int64_t, 14)[count++] = i;
    }
    return count;
}
