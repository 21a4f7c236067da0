/* Runs of regions: chosen, and in order. */

#include "ods/pipeline/image/regions.h"

/* Returns how many runs there are of the wanted regions; see `chosen_runs`. */
KERNEL_INT(choose_runs, "r16[runs] runs, b1[total] wanted, out r16[runs] out")
{
    return chosen_runs(ARRAY(const Run, 0), SIZE(0, 0), ARRAY(const bool, 1), SIZE(1, 0), ARRAY(Run, 2)).runs;
}

static int by_order(const void *left, const void *right)
{
    const int64_t a = order_of_run(*(const Run *)left), b = order_of_run(*(const Run *)right);
    return (a > b) - (a < b);
}

int64_t sorted_runs(const Run *runs, int64_t count, Run *out)
{
    int64_t kept = 0;
    for (int64_t i = 0; i < count; i++)
        if (runs[i].region > 0)
            out[kept++] = runs[i];
    qsort(out, (size_t)kept, sizeof *out, by_order);
    return kept;
}

/* Returns how many runs of numbered regions there are; see `sorted_runs`. */
KERNEL_INT(sort_runs, "r16[runs] runs, out r16[runs] out")
{
    return sorted_runs(ARRAY(const Run, 0), SIZE(0, 0), ARRAY(Run, 1));
}
