/* Clear water and bodies by bearing sector (sectors.py). */

#include "kernel.h"


typedef double TurnRow[3];

/* Sets where echoes are as seen from the vehicle: azimuth, half width, distance of the near edge, in its middle and at
   both its sides. Echoes: `Extent` of fan_mask.py; the head: its place from the vehicle, NED, and how it is turned. */
KERNEL(echoes_around, "f8[m,5] echoes, f8[3] place, f8[3,3] turned, out f8[m] azimuth, out f8[m] half_width, "
                      "out f8[m] distance")
{
    const double *place = ARRAY(double, 1);
    const TurnRow *turned = ARRAY(const TurnRow, 2);
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        const double *echo = ARRAY(const double, 0) + 5 * k, near = echo[0], half = echo[2];
        const double level = near * cos(echo[4]), down = -near * sin(echo[4]);
        double azimuth = 0.0, wide = 0.0, distance = INFINITY;
        for (int side = 0; side < 3; side++) {
            const double bearing = echo[3] + (side == 0 ? 0.0 : side == 1 ? -half : half);
            const double forward = level * cos(bearing), starboard = level * sin(bearing);
            const double north = place[0] + turned[0][0] * forward + turned[0][1] * starboard + turned[0][2] * down;
            const double east = place[1] + turned[1][0] * forward + turned[1][1] * starboard + turned[1][2] * down;
            const double seen = atan2(east, north);
            azimuth = side == 0 ? seen : azimuth;
            wide = larger(wide, fabs(remainder(seen - azimuth, 2.0 * PI)));
            distance = smaller(distance, hypot(north, east));
        }
        ARRAY(double, 3)[k] = azimuth;
        ARRAY(double, 4)[k] = wide;
        ARRAY(double, 5)[k] = distance;
    }
}

/* Sets `clear` to the first ring of each sector from which on at least `shortest` are free as a whole, and to the first
   one behind it that is not; both 0 where there is none. `cell`, `bin`: which cells, of `free`, are in which sector and
   ring, sector * rings + ring. */
KERNEL(clear_rings, "b1[:] free, i4[pairs] cell, i4[pairs] bin, int rings, int shortest, out i8[sectors,2] clear")
{
    const bool *free = ARRAY(const bool, 0);
    const int32_t *cell = ARRAY(const int32_t, 1), *bin = ARRAY(const int32_t, 2);
    const int64_t cells = SIZE(0, 0), sectors = SIZE(5, 0), rings = larger_i(INT(3), 0), bins = sectors * rings;
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
   infinite where there is none. Bodies: `OccupiedSectors` of sectors.py, at azimuths from -PI to PI. */
KERNEL(nearest_edge, "f8[bodies] azimuth, f8[bodies] half_width, f8[bodies] distance_m, f8[bodies] sigma_m, float sigmas, "
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
            const double turn = (double)(2 * sector + 1) * half - azimuth[k], off = fabs(turn > PI ? turn - 2.0 * PI : turn);
            if (off <= half_width[k] + half)
                nearest[sector] = smaller(nearest[sector], distance);
        }
    }
}
