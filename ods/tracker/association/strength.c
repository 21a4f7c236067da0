/* Counts of the strengths of echoes of nothing, by range, and what they say of a place (strength.h, strength.py). */

#include "ods/tracker/association/strength.h"
#include "ods/tracker/measurement/scan.h"

#define LEAST_SIGMA_DB 0.5
/* Keeps means over nothing finite. */
#define LEAST 1e-9

/* Rows of the counts. */
enum { COUNT, SUM, SQUARES, SUMS };

/* Returns the class of a range, of so many between two. */
static int64_t ring_of(double range_m, double nearest, double farthest, int64_t rings)
{
    const double place = (range_m - nearest) / (farthest - nearest) * (double)rings;
    return (int64_t)smaller(larger(place, 0.0), (double)rings - 1.0);
}

/* Takes in the echoes that are `free` and tell a strength; returns the sum of the counts. */
KERNEL_FLOAT(strength_count, "out f8[3,rings] counts, f8[12,m] echoes, b1[m] free, float nearest, float farthest")
{
    const int64_t rings = SIZE(0, 1), m = SIZE(1, 1);
    double *counts = ARRAY(double, 0), sum = 0.0;
    const EchoRows echoes = echo_rows(ARRAY(double, 1), m);
    const bool *is_free = ARRAY(const bool, 2);
    for (int64_t j = 0; j < m; j++) {
        const double strength = echoes.strength[j];
        if (is_free[j] && strength > 0.0) {
            double *ring = counts + ring_of(echoes.range_m[j], FLOAT(3), FLOAT(4), rings);
            ring[COUNT * rings] += 1.0;
            ring[SUM * rings] += strength;
            ring[SQUARES * rings] += square(strength);
        }
    }
    for (int64_t ring = 0; ring < rings; ring++)
        sum += counts[COUNT * rings + ring];
    return sum;
}

/* Fills in the table of `Typical` at n ranges. `pooled`: the strengths in all ranges count for so many echoes in each;
   `few`: so many echoes tell half of what there is to know. */
KERNEL(strength_typical,
       "f8[3,rings] counts, f8[n] range_m, float nearest, float farthest, float pooled, float few, out f8[3,n] typical")
{
    const int64_t rings = SIZE(0, 1), n = SIZE(1, 0);
    const double *counts = ARRAY(const double, 0), *range_m = ARRAY(const double, 1);
    const Typical told = typical_rows(ARRAY(double, 6), n);
    double pooled[SUMS] = {0.0};
    for (int64_t row = 0; row < SUMS; row++)
        for (int64_t ring = 0; ring < rings; ring++)
            pooled[row] += counts[row * rings + ring];
    const double weight = FLOAT(4) / larger(pooled[COUNT], LEAST);
    for (int64_t i = 0; i < n; i++) {
        const double *ring = counts + ring_of(range_m[i], FLOAT(2), FLOAT(3), rings);
        const double count = larger(ring[COUNT * rings] + weight * pooled[COUNT], LEAST);
        const double mean = (ring[SUM * rings] + weight * pooled[SUM]) / count;
        const double mean_square = (ring[SQUARES * rings] + weight * pooled[SQUARES]) / count;
        told.mean_db[i] = mean;
        told.sigma_db[i] = sqrt(larger(square(LEAST_SIGMA_DB), mean_square - square(mean)));
        told.known[i] = ring[COUNT * rings] / (ring[COUNT * rings] + FLOAT(5));
    }
}

KERNEL_FLOAT(strength_evidence, "float excess, float echoes, float sigma_db, float known, f8[3] law")
{
    return evidence_of_strength(FLOAT(0), FLOAT(1), FLOAT(2), FLOAT(3), ARRAY(const StrengthLaw, 4));
}
