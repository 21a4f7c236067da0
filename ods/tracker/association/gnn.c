/* Pairs without a rival, and the scores of the others as a matrix (gnn.py). */

#include "ods/tracker/association/gnn.h"

/* Marks as chosen the pairs of the objects of `group` that have no rival; fills in those that have, and returns how
   many these are. Left out are echoes taken and scores not above 0. */
KERNEL_INT(gnn_undisputed, HYPOTHESES ", b1[n] group, b1[m] taken, out b1[p] chosen, out i8[p] disputed")
{
    const Hypotheses pairs = hypotheses_from(arguments, 0);
    const int64_t n = SIZE(4, 0), m = SIZE(5, 0);
    const bool *group = ARRAY(const bool, 4), *taken = ARRAY(const bool, 5);
    bool *possible = SCRATCH(bool, pairs.count);
    for (int64_t k = 0; k < pairs.count; k++)
        possible[k] = is_pair(&pairs, k, n, m) && group[pairs.objects[k]] && !taken[pairs.echoes[k]];
    return choose_undisputed(&pairs, possible, n, m, ARRAY(bool, 6), ARRAY(int64_t, 7));
}

/* Returns the place that `number` has among those met so far, `count` of them. */
static int64_t place_of(int64_t number, int64_t *places, int64_t *count)
{
    if (places[number] < 0)
        places[number] = (*count)++;
    return places[number];
}

/* Sets in which row and column of a matrix each of d pairs is, numbered as they are met; `size`: rows and columns.
   Pairs must be of n objects and m echoes, as those of `gnn_undisputed` are. */
KERNEL(gnn_places, HYPOTHESES ", i8[d] disputed, int n, int m, out i8[d] rows, out i8[d] columns, out i8[2] size")
{
    const Hypotheses pairs = hypotheses_from(arguments, 0);
    const int64_t *disputed = ARRAY(const int64_t, 4), n = larger_i(INT(5), 0), m = larger_i(INT(6), 0);
    int64_t *rows = ARRAY(int64_t, 7), *columns = ARRAY(int64_t, 8), *size = ARRAY(int64_t, 9);
    int64_t *row_of = SCRATCH(int64_t, n), *column_of = SCRATCH(int64_t, m);
    memset(row_of, -1, (size_t)n * sizeof *row_of);
    memset(column_of, -1, (size_t)m * sizeof *column_of);
    size[0] = size[1] = 0;
    for (int64_t d = 0; d < SIZE(4, 0); d++) {
        const int64_t k = disputed[d];
        if (k < 0 || k >= pairs.count || !is_pair(&pairs, k, n, m))
            continue;
        rows[d] = place_of(pairs.objects[k], row_of, &size[0]);
        columns[d] = place_of(pairs.echoes[k], column_of, &size[1]);
    }
}
