/* One object of a table with an object a column: how the filters read and write their numbers. */

#ifndef ODS_COLUMN_H
#define ODS_COLUMN_H

#include "kernel.h"

/* Its number of row r is AT(column, r). */
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

#endif
