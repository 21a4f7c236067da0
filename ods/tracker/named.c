/* Tables with an object a column, one below the other, appended to and removed from in place (named.py): cells of 8
   bytes each. */

#include "kernel.h"

/* Columns of a table that stay, next to each other. */
typedef struct {
    int64_t first, count;
} Run;

/* Removes the columns that are not `kept` from the table of so many rows at the start of `cells`; returns how many
   stay, -1 for a table that does not fit in there. */
KERNEL_INT(table_keep, "out i8[size] cells, int rows, b1[n] kept")
{
    int64_t *cells = ARRAY(int64_t, 0), *to = cells, runs = 0, left = 0;
    const int64_t rows = INT(1), n = SIZE(2, 0);
    const bool *kept = ARRAY(const bool, 2);
    Run *run = SCRATCH(Run, n);
    if (rows < 0 || (n > 0 && rows > SIZE(0, 0) / n))
        return -1;
    for (int64_t i = 0; i < n; i++) {
        if (!kept[i])
            continue;
        if (i == 0 || !kept[i - 1])
            run[runs++] = (Run){i, 0};
        run[runs - 1].count++;
        left++;
    }
    for (int64_t row = 0; row < rows; row++)
        for (int64_t k = 0; k < runs; k++) {
            memmove(to, cells + row * n + run[k].first, (size_t)run[k].count * sizeof *to);
            to += run[k].count;
        }
    return left;
}

/* Appends `count` columns of zeros to the `n` of the table of so many rows at the start of `cells`; returns whether it
   fits in there. */
KERNEL_BOOL(table_extend, "out i8[size] cells, int rows, int n, int count")
{
    int64_t *cells = ARRAY(int64_t, 0);
    const int64_t rows = INT(1), n = INT(2), count = INT(3), size = SIZE(0, 0);
    if (rows < 0 || n < 0 || count < 0 || n > size || count > size || (n + count > 0 && rows > size / (n + count)))
        return false;
    for (int64_t row = rows - 1; row >= 0; row--) {
        int64_t *to = cells + row * (n + count);
        memmove(to, cells + row * n, (size_t)n * sizeof *to);
        memset(to + n, 0, (size_t)count * sizeof *to);
    }
    return true;
}
