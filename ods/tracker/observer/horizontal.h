/* North and east of all objects, by the observers, as kernels take it: see horizontal.py. */

#ifndef ODS_HORIZONTAL_H
#define ODS_HORIZONTAL_H

#include "ods/tracker/measurement/model.h"

/* One object of a table with an object a column: its number of row r is AT(column, r). */
typedef struct {
    double *at;
    int64_t step; /* from one row to the next */
} Column;

#define AT(column, row) ((column).at[(row) * (column).step])

/* Returns object i of a table of n objects. */
static inline Column column_of(double *table, int64_t n, int64_t i)
{
    return (Column){table + i, n};
}

/* Returns whether all of `rows` are objects of a table of n. */
static inline bool all_inside(const int64_t *rows, int64_t count, int64_t n)
{
    for (int64_t k = 0; k < count; k++)
        if (rows[k] < 0 || rows[k] >= n)
            return false;
    return true;
}

/* The first hypothesis; those after it are kinds of motion, of which some observers know one. */
enum { RESTING, MOVING };

/* Rows of a state: north, east and their velocities, of which this is the first. */
enum { NORTH, EAST, VELOCITY, STATE = 4 };

/* Where n objects are by 1 + `models` hypotheses, that at rest first. */
typedef struct {
    double *share;         /* (models, n) probability of each kind of motion of an object that moves */
    double *position;      /* (1 + models, 2, n) */
    double *variance;      /* (1 + models, 2, n) */
    double *covariance_ne; /* (1 + models, n) */
    double *unseen;        /* (1 + models, UNSEEN, STATE, n) derivatives of the states by what is not seen */
    int64_t models, n;
} HorizontalState;

/* A `HorizontalState` in a signature: five arguments. */
#define HORIZONTAL_STATE                                                                                                \
    "f8[models,n] share, f8[hypotheses,2,n] position, f8[hypotheses,2,n] variance, f8[hypotheses,n] covariance_ne, "    \
    "f8[hypotheses,4,4,n] unseen"

/* Returns the state of the five arguments after the first. */
static inline HorizontalState horizontal_from(const Argument *arguments)
{
    return (HorizontalState){ARRAY(double, 1), ARRAY(double, 2), ARRAY(double, 3), ARRAY(double, 4), ARRAY(double, 5),
                             smaller_i(SIZE(1, 0), SIZE(2, 0) - 1), SIZE(1, 1)};
}

/* What `count` measurements say beyond north and east: (2, count) each, if the objects rest and if they move. */
typedef struct {
    double *log_likelihood;           /* of the measurement, but for a number that both share */
    double *step, *variance;          /* by which the height is another, and its variance then, */
    double *square, *square_variance; /* and the same of the height's square */
} Learned;

/* Names the rows of a (5, 2, count) table. */
static inline Learned learned_rows(double *table, int64_t count)
{
    const int64_t row = 2 * count;
    return (Learned){table, table + row, table + 2 * row, table + 3 * row, table + 4 * row};
}

/* Fills `mean` with the sum of weight[h] rows[h], where rows[h] begins `apart` numbers after rows[h - 1]; (n,) each. */
static inline void mixture(const double *restrict weight, const double *restrict rows, int64_t apart, int64_t hypotheses,
                           int64_t n, double *restrict mean)
{
    memset(mean, 0, (size_t)n * sizeof *mean);
    for (int64_t h = 0; h < hypotheses; h++)
        for (int64_t i = 0; i < n; i++)
            mean[i] += weight[h * n + i] * rows[h * apart + i];
}

#endif
