/* The rays for one object. */

#ifndef ODS_RAY_BUDGET_H
#define ODS_RAY_BUDGET_H

#include "kernel.h"

/* ray_budget.RayFan: borders of the rays' cells. */
typedef struct {
    const double *bearing;   /* (columns + 1,) rad */
    const double *elevation; /* (columns, cells + 1) rad, rising in each row */
    int64_t columns, cells;
    double farthest_m;
} RayFan;

/* A `RayFan` in a signature: three arguments. */
#define RAY_FAN "f8[:] bearing, f8[fan_columns,:] elevation, float farthest_m"

/* Returns the rays of the three arguments from number k on. */
static inline RayFan ray_fan_from(const Argument *arguments, int k)
{
    return (RayFan){
        .bearing = ARRAY(const double, k),
        .elevation = ARRAY(const double, k + 1),
        .columns = smaller_i(SIZE(k, 0) - 1, SIZE(k + 1, 0)),
        .cells = SIZE(k + 1, 1) - 1,
        .farthest_m = FLOAT(k + 2),
    };
}

/* Returns the elevations of the borders of a column's cells: cells + 1. */
static inline const double *elevations_of(const RayFan *rays, int64_t column)
{
    return rays->elevation + column * (rays->cells + 1);
}

/* Returns the bearing of a column's middle, rad. */
static inline double middle_of(const RayFan *rays, int64_t column)
{
    return 0.5 * (rays->bearing[column] + rays->bearing[column + 1]);
}

#endif
