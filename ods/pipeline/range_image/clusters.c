/* Bodies in a range image: connected pixels whose ranges differ little for the angle between them. */

#include "ods/compiled/kernel.h"

/* Neighbours so many pixels away, across and up, are looked at: images have gaps. */
#define REACH 2

/* Returns the least pixel of the body that pixel i is in, and makes the way there short. */
static int32_t root_of(int32_t *parent, int32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static void join(int32_t *parent, int32_t i, int32_t k)
{
    const int32_t a = root_of(parent, i), b = root_of(parent, k);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

/* Numbers the pixels of each body from 1 on, 0: of none. Two pixels are of one when their ranges differ by no more than
   noise_m and, for each rad between them, the nearer range times slope. Returns how many bodies there are. */
KERNEL_INT(cluster_ranges, "f4[bearings,elevations] range_m, b1[bearings,elevations] wanted, float across, float up, "
                           "float noise_m, float slope, out i4[bearings,elevations] numbers")
{
    const float *range_m = ARRAY(float, 0);
    const bool *wanted = ARRAY(bool, 1);
    const double across = FLOAT(2), up = FLOAT(3), noise_m = FLOAT(4), slope = FLOAT(5);
    int32_t *numbers = ARRAY(int32_t, 6);
    const int64_t columns = SIZE(0, 0), rows = SIZE(0, 1), count = columns * rows;
    int32_t *parent = SCRATCH(int32_t, count + 1);
    double room[REACH + 1][REACH + 1];
    for (int a = 0; a <= REACH; a++)
        for (int b = 0; b <= REACH; b++)
            room[a][b] = slope * sqrt(square(a * across) + square(b * up));
    for (int64_t i = 0; i < count; i++)
        parent[i] = (int32_t)i;
    for (int64_t column = 0; column < columns; column++)
        for (int64_t row = 0; row < rows; row++) {
            const int64_t i = column * rows + row;
            if (!wanted[i])
                continue;
            for (int64_t a = 0; a <= REACH && a <= column; a++)
                for (int64_t b = a ? -REACH : -smaller_i(REACH, row); b <= (a ? REACH : -1); b++) {
                    if (row + b < 0 || row + b >= rows)
                        continue;
                    const int64_t k = i - a * rows + b;
                    const double nearer = smaller(range_m[i], range_m[k]);
                    if (wanted[k] && fabs((double)range_m[i] - range_m[k]) <= noise_m + nearer * room[a][b < 0 ? -b : b])
                        join(parent, (int32_t)i, (int32_t)k);
                }
        }
    int32_t bodies = 0;
    for (int64_t i = 0; i < count; i++) {
        numbers[i] = 0;
        if (!wanted[i])
            continue;
        const int32_t root = root_of(parent, (int32_t)i);
        numbers[i] = root == i ? ++bodies : numbers[root];
    }
    return bodies;
}
