/* Echoes of tracked objects, by how much each common error moves them (sightings.py), their normal equations, and the
   errors that fit them (least_squares.py). */

#include "kernel.h"

/* Columns of a design, as in sightings.py: unknowns of an object, then errors in common. */
enum { NORTH_OF_OBJECT, EAST_OF_OBJECT, NEARER, DEPTH, YAW, TURN, SCALE, LATENCY, NORTH, EAST, COLUMNS };
_Static_assert(COLUMNS == 10, "as in the signatures");
/* Columns of the normal equations: the last one is that of the places seen. */
#define WHOLE (COLUMNS + 1)
/* Errors in common, and the places seen. */
#define REST (WHOLE - YAW)
/* Errors fitted at once. */
#define MOST 4

typedef double Equations[WHOLE][WHOLE];
typedef double Information[REST][REST];

/* ---------------------------------------------------------------- sightings */

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

/* ---------------------------------------------------------------- normal equations */

/* Lets what was seen count less, and rates count from `seconds` later: `from` are the columns whose values have changed
   by then, `of` those of their rates. */
KERNEL(fade_sums, "out f8[objects,11,11] sums, float fade, float seconds, i8[rates] from, i8[rates] of")
{
    const double fade = FLOAT(1), seconds = FLOAT(2);
    const int64_t *from = ARRAY(const int64_t, 3), *of = ARRAY(const int64_t, 4);
    for (int64_t r = 0; r < SIZE(3, 0); r++)
        if ((uint64_t)from[r] >= WHOLE || (uint64_t)of[r] >= WHOLE)
            return;
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        Equations *sums = &ARRAY(Equations, 0)[k];
        for (int64_t r = 0; r < SIZE(3, 0); r++)
            for (int i = 0; i < WHOLE; i++)
                (*sums)[i][of[r]] -= seconds * (*sums)[i][from[r]];
        for (int64_t r = 0; r < SIZE(3, 0); r++)
            for (int i = 0; i < WHOLE; i++)
                (*sums)[of[r]][i] -= seconds * (*sums)[from[r]][i];
        for (int i = 0; i < WHOLE; i++)
            for (int j = 0; j < WHOLE; j++)
                (*sums)[i][j] *= fade;
    }
}

/* Adds sightings, whitened, to the normal equations of their objects, number `rows` of them, and to how often each was
   seen. `first`: the places from which each object's are counted. */
KERNEL(add_sightings, "f8[k,2] place, f8[k,2,10] design, f8[k,2,2] whitening, i8[k] rows, f8[objects,2] first, "
                      "out f8[objects,11,11] sums, out f8[objects] seen")
{
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        const int64_t row = ARRAY(int64_t, 3)[k];
        if ((uint64_t)row >= (uint64_t)SIZE(4, 0))
            continue;
        const double *design = ARRAY(const double, 1) + 2 * COLUMNS * k, *white = ARRAY(const double, 2) + 4 * k;
        double equation[2][WHOLE];
        for (int i = 0; i < 2; i++) {
            for (int c = 0; c < COLUMNS; c++)
                equation[i][c] = white[2 * i] * design[c] + white[2 * i + 1] * design[COLUMNS + c];
            equation[i][COLUMNS] = 0.0;
            for (int axis = 0; axis < 2; axis++)
                equation[i][COLUMNS] +=
                    white[2 * i + axis] * (ARRAY(double, 0)[2 * k + axis] - ARRAY(double, 4)[2 * row + axis]);
        }
        Equations *sums = &ARRAY(Equations, 5)[row];
        for (int i = 0; i < WHOLE; i++)
            for (int j = 0; j < WHOLE; j++)
                (*sums)[i][j] += equation[0][i] * equation[0][j] + equation[1][i] * equation[1][j];
        ARRAY(double, 6)[row] += 1.0;
    }
}

/* ---------------------------------------------------------------- fit */

/* The equations of some errors. */
typedef struct {
    double matrix[MOST][MOST], right[MOST];
} System;

/* Sets `x` to the solution, by elimination; returns whether there is one. */
static bool solve(System system, int64_t size, double *x)
{
    for (int64_t c = 0; c < size; c++) {
        int64_t pivot = c;
        for (int64_t i = c + 1; i < size; i++)
            if (fabs(system.matrix[i][c]) > fabs(system.matrix[pivot][c]))
                pivot = i;
        if (system.matrix[pivot][c] == 0.0)
            return false;
        for (int64_t j = 0; j < size; j++) {
            const double held = system.matrix[c][j];
            system.matrix[c][j] = system.matrix[pivot][j];
            system.matrix[pivot][j] = held;
        }
        const double held = system.right[c];
        system.right[c] = system.right[pivot];
        system.right[pivot] = held;
        for (int64_t i = c + 1; i < size; i++) {
            const double factor = system.matrix[i][c] / system.matrix[c][c];
            for (int64_t j = c; j < size; j++)
                system.matrix[i][j] -= factor * system.matrix[c][j];
            system.right[i] -= factor * system.right[c];
        }
    }
    for (int64_t i = size - 1; i >= 0; i--) {
        x[i] = system.right[i];
        for (int64_t j = i + 1; j < size; j++)
            x[i] -= system.matrix[i][j] * x[j];
        x[i] /= system.matrix[i][i];
    }
    return true;
}

/* Adds a share of an object's information of the errors in `columns`. */
static void add_object(System *system, const Information object, double share, const int64_t *columns, int64_t size)
{
    for (int64_t i = 0; i < size; i++) {
        for (int64_t j = 0; j < size; j++)
            system->matrix[i][j] += share * object[columns[i]][columns[j]];
        system->right[i] += share * object[columns[i]][REST - 1];
    }
}

/* Returns the squared residuals that the errors `x` leave of an object, summed. */
static double rest_of(const Information object, const double *x, const int64_t *columns, int64_t size)
{
    double rest = object[REST - 1][REST - 1];
    for (int64_t i = 0; i < size; i++) {
        rest -= 2.0 * x[i] * object[columns[i]][REST - 1];
        for (int64_t j = 0; j < size; j++)
            rest += x[i] * x[j] * object[columns[i]][columns[j]];
    }
    return rest;
}

/* Sets the errors in `columns` that fit n objects best, all others taken to be 0; the diagonal of their covariance for
   residuals of variance 1; the sums over objects of the squares by which they change if that one is left out; and the
   mean square left, of all and then without each one. Returns whether they can be distinguished. */
KERNEL_BOOL(fit_errors, "f8[n,7,7] information, f8[n] freedom, i8[p] columns, out f8[p] value, out f8[p] covariance, "
                        "out f8[p] changes, out f8[:] left")
{
    const Information *objects = ARRAY(const Information, 0);
    const double *freedom = ARRAY(const double, 1);
    const int64_t *columns = ARRAY(const int64_t, 2), n = SIZE(0, 0), size = SIZE(2, 0);
    double *value = ARRAY(double, 3), *changes = ARRAY(double, 5), *left = ARRAY(double, 6);
    System all = {0};
    for (int64_t i = 0; i < size; i++)
        if (size > MOST || (uint64_t)columns[i] >= REST)
            return false;
    if (SIZE(6, 0) != n + 1)
        return false;
    for (int64_t k = 0; k < n; k++)
        add_object(&all, objects[k], 1.0, columns, size);
    if (!solve(all, size, value))
        return false;
    for (int64_t i = 0; i < size; i++) {
        System unit = all;
        double column[MOST];
        for (int64_t j = 0; j < size; j++)
            unit.right[j] = i == j;
        solve(unit, size, column);
        ARRAY(double, 4)[i] = column[i];
        changes[i] = 0.0;
    }
    for (int64_t without = -1; without < n; without++) {
        System others = all;
        double x[MOST], rest = 0.0, free = 0.0;
        if (without >= 0)
            add_object(&others, objects[without], -1.0, columns, size);
        if (!solve(others, size, x))
            return false;
        for (int64_t i = 0; i < size; i++)
            changes[i] += square(x[i] - value[i]);
        for (int64_t k = 0; k < n; k++)
            if (k != without) {
                rest += rest_of(objects[k], x, columns, size);
                free += freedom[k];
            }
        left[without + 1] = rest / free;
    }
    return true;
}
