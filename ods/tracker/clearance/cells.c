/* Cells of the water around the vehicle: what a ping showed of them, how far they are from what is not known, and until
   when they are known to be empty. */

#include "ods/tracker/measurement/arctangent.h"

typedef double TurnRow[3];

/* Returns which of `count` + 2 cells a place is in, the first and the last of which are beyond both borders. */
static inline int32_t cell_at(double place, int64_t count)
{
    return (int32_t)smaller(larger(place + 1.0, 0.0), (double)count + 1.0);
}

/* Tells of cells of the layer around the vehicle whether a ping showed them to be empty, or heard something there, and
   how much is seen above and below the layer there, m: `empty`, `heard`, `room`. The fan: `FanMask`, with a rim of
   nothing; cells and head: `Layer` of free_grid.py. */
KERNEL(layer_in_fan,
       "u1[:,:] shown, float bearing_min_rad, float bearing_max_rad, float range_min_m, float range_max_m, "
       "float half_vertical_sine, float half_height_m, f8[3,3] turned, float north_m, float east_m, float down_m, "
       "float cell_m, out b1[rows,columns] empty, out b1[rows,columns] heard, out f8[rows,columns] room")
{
    const int64_t bearings = SIZE(0, 0) - 2, ranges = SIZE(0, 1) - 2, rows = SIZE(12, 0), columns = SIZE(12, 1);
    const double per_rad = (double)bearings / (FLOAT(2) - FLOAT(1)), per_m = (double)ranges / (FLOAT(4) - FLOAT(3));
    const TurnRow *turned = ARRAY(const TurnRow, 7);
    const double below = FLOAT(10);
    int32_t *at = SCRATCH(int32_t, columns);
    for (int64_t i = 0; i < rows && bearings > 0 && ranges > 0; i++) {
        const double north = FLOAT(8) + (double)i * FLOAT(11);
        double *restrict room = ARRAY(double, 14) + i * columns;
        for (int64_t j = 0; j < columns; j++) {
            const double east = FLOAT(9) + (double)j * FLOAT(11);
            const double forward = turned[0][0] * north + turned[1][0] * east + turned[2][0] * below;
            const double starboard = turned[0][1] * north + turned[1][1] * east + turned[2][1] * below;
            const double down = turned[0][2] * north + turned[1][2] * east + turned[2][2] * below;
            const double range = sqrt(forward * forward + starboard * starboard + down * down);
            const int32_t column = cell_at((arctangent(starboard, forward) - FLOAT(1)) * per_rad, bearings);
            at[j] = column * (int32_t)(ranges + 2) + cell_at((range - FLOAT(3)) * per_m, ranges);
            room[j] = range * FLOAT(5) - fabs(down) - FLOAT(6);
        }
        for (int64_t j = 0; j < columns; j++) {
            const uint8_t shown = ARRAY(uint8_t, 0)[at[j]];
            ARRAY(bool, 12)[i * columns + j] = shown & 1;
            ARRAY(bool, 13)[i * columns + j] = (shown & 2) != 0;
        }
    }
}

/* By how many steps to a neighbour each cell is away from one that is not in the mask, or from the rim: one pass from
   each of two opposite corners. */
KERNEL(cells_from_others, "b1[rows,columns] mask, out u2[rows,columns] away")
{
    const bool *mask = ARRAY(bool, 0);
    uint16_t *away = ARRAY(uint16_t, 1);
    const int64_t rows = SIZE(0, 0), columns = SIZE(0, 1);
    for (int64_t i = 0, k = 0; i < rows; i++)
        for (int64_t j = 0; j < columns; j++, k++) {
            const int up = i > 0 ? away[k - columns] : 0, left = j > 0 ? away[k - 1] : 0;
            away[k] = (uint16_t)(mask[k] ? 1 + (up < left ? up : left) : 0);
        }
    for (int64_t i = rows - 1, k = rows * columns - 1; i >= 0; i--)
        for (int64_t j = columns - 1; j >= 0; j--, k--) {
            const int down = i < rows - 1 ? away[k + columns] : 0, right = j < columns - 1 ? away[k + 1] : 0;
            const int nearer = 1 + (down < right ? down : right);
            if (nearer < away[k])
                away[k] = (uint16_t)nearer;
        }
}

/* Prolongs until when cells are known to be empty, s: by how far they are `away` from what is not (`cells_from_others`),
   at most until something may have come from above or below, `above_s`; where something was heard nothing is known. A
   cell is `cell_s` wide for what comes as fast as anything can. */
KERNEL(hold_empty, "rows out f8[rows,columns] until_s, u2[rows,columns] away, b1[rows,columns] heard, "
                   "rows f8[rows,columns] above_s, float since_s, float cell_s, float never_s")
{
    const double since = FLOAT(4), cell = FLOAT(5), half_diagonal = sqrt(0.5);
    const int64_t columns = SIZE(0, 1);
    for (int64_t i = 0, k = 0; i < SIZE(0, 0); i++)
        for (int64_t j = 0; j < columns; j++, k++) {
            double *until = ARRAY(double, 0) + i * STRIDE(0) + j;
            const double away = (double)ARRAY(uint16_t, 1)[k];
            const double hold = larger(away * half_diagonal - 1.0 - half_diagonal, 0.0) * cell;
            if (ARRAY(bool, 2)[k])
                *until = FLOAT(6);
            else if (away >= 2.0)
                *until = larger(*until, smaller(since + hold, ARRAY(double, 3)[i * STRIDE(3) + j]));
        }
}
