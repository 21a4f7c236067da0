/* Clear water and bodies by bearing sector (sectors.py). */

#include "kernel.h"

#define PI 3.14159265358979323846

/* Sets `clear` to the first ring of each sector from which on at least `shortest` are free as a whole, and to the first
   one behind it that is not; both 0 where there is none. `cell`, `bin`: which cells, of `free`, are in which sector and
   ring, sector * rings + ring. */
KERNEL(clear_rings, "b1[:] free, i8[pairs] cell, i8[pairs] bin, int rings, int shortest, out i8[sectors,2] clear")
{
    const bool *free = ARRAY(const bool, 0);
    const int64_t *cell = ARRAY(const int64_t, 1), *bin = ARRAY(const int64_t, 2), rings = larger_i(INT(3), 0);
    const int64_t cells = SIZE(0, 0), sectors = SIZE(5, 0), bins = sectors * rings;
    bool *taken = ZEROS(bool, bins);
    for (int64_t k = 0; k < SIZE(1, 0); k++)
        if ((uint64_t)cell[k] < (uint64_t)cells && (uint64_t)bin[k] < (uint64_t)bins && !free[cell[k]])
            taken[bin[k]] = true;
    for (int64_t sector = 0; sector < sectors; sector++) {
        const bool *row = taken + sector * rings;
        int64_t *clear = ARRAY(int64_t, 5) + 2 * sector, first = 0, end = 0;
        while (end < rings && (!row[end] || end - first < INT(4))) {
            if (row[end])
                first = end + 1;
            end++;
        }
        const bool is_long = end - first >= INT(4);
        clear[0] = is_long ? first : 0;
        clear[1] = is_long ? end : 0;
    }
}

/* Sets `nearest` to the distance of the nearest body in each sector, less a number of standard deviations, 0 at least;
   infinite where there is none. Bodies: `Bodies` of sectors.py. */
KERNEL(nearest_body, "f8[bodies] azimuth, f8[bodies] half_width, f8[bodies] distance_m, f8[bodies] sigma_m, float sigmas, "
                     "out f8[sectors] nearest")
{
    const double *azimuth = ARRAY(const double, 0), *half_width = ARRAY(const double, 1);
    double *nearest = ARRAY(double, 5);
    const int64_t sectors = SIZE(5, 0);
    const double half = PI / (double)sectors;
    for (int64_t sector = 0; sector < sectors; sector++)
        nearest[sector] = INFINITY;
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        const double distance = larger(ARRAY(double, 2)[k] - FLOAT(4) * ARRAY(double, 3)[k], 0.0);
        for (int64_t sector = 0; sector < sectors; sector++) {
            const double off = fabs(remainder((double)(2 * sector + 1) * half - azimuth[k], 2.0 * PI));
            if (off <= half_width[k] + half)
                nearest[sector] = smaller(nearest[sector], distance);
        }
    }
}
