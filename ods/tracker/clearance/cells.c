/* Cells of the water around the vehicle: what a ping showed of them, how far they are from what is not known, and until
   when they are known to be empty. */

#include "ods/tracker/measurement/arctangent.h"

typedef double TurnRow[3];

/* A fan's borders, and the cells of what it showed, with a rim of nothing. */
typedef struct {
    double first_rad, per_rad, first_m, per_m, bearings, ranges;
} FanCells;

/* A row of cells of the layer, in the frame of the head: where it begins, and what it goes on by, m. */
typedef struct {
    double forward, starboard, down, step_forward, step_starboard, step_down;
} LayerRow;

/* Sets `at` to the cells of the fan that a row's are in, `room` to the half height of the fan there less the height of
   the layer's own borders, m. */
static void look_along(LayerRow row, FanCells fan, double sine, double half_height_m, int64_t columns,
                       int32_t *restrict at, double *restrict room)
{
    for (int64_t j = 0; j < columns; j++) {
        const double step = (double)(int32_t)j, forward = row.forward + step * row.step_forward;
        const double starboard = row.starboard + step * row.step_starboard, down = row.down + step * row.step_down;
        const double range = sqrt(forward * forward + starboard * starboard + down * down);
        const double beam = (arctangent(starboard, forward) - fan.first_rad) * fan.per_rad + 1.0;
        const double sample = (range - fan.first_m) * fan.per_m + 1.0;
        at[j] = (int32_t)smaller(larger(beam, 0.0), fan.bearings + 1.0) * (int32_t)(fan.ranges + 2.0) +
                (int32_t)smaller(larger(sample, 0.0), fan.ranges + 1.0);
        room[j] = range * sine - fabs(down) - half_height_m;
    }
}

/* Tells of cells of the layer around the vehicle whether a ping showed them to be empty, or received something there, and
   how much is seen above and below the layer there, m: `empty`, `received`, `room`. `shown`: of `FanMask`, with its rim;
   cells and head: `Layer` of free_grid.py. */
KERNEL(layer_in_fan,
       "u1[:,:] shown, float bearing_min_rad, float bearing_max_rad, float range_min_m, float range_max_m, "
       "float half_vertical_sine, float half_height_m, f8[3,3] turned, float north_m, float east_m, float down_m, "
       "float cell_m, out b1[rows,columns] empty, out b1[rows,columns] received, out f8[rows,columns] room")
{
    const double bearings = (double)(SIZE(0, 0) - 2), ranges = (double)(SIZE(0, 1) - 2);
    const FanCells fan = {FLOAT(1), bearings / (FLOAT(2) - FLOAT(1)), FLOAT(3), ranges / (FLOAT(4) - FLOAT(3)),
                          bearings, ranges};
    const TurnRow *to_ned = ARRAY(const TurnRow, 7);
    const int64_t rows = SIZE(12, 0), columns = SIZE(12, 1);
    const double east = FLOAT(9), below = FLOAT(10), cell = FLOAT(11);
    int32_t *at = SCRATCH(int32_t, columns);
    for (int64_t i = 0; i < rows && bearings > 0.0 && ranges > 0.0; i++) {
        const double north = FLOAT(8) + (double)i * cell;
        double begin[3];
        for (int k = 0; k < 3; k++)
            begin[k] = to_ned[0][k] * north + to_ned[1][k] * east + to_ned[2][k] * below;
        const LayerRow row = {begin[0], begin[1], begin[2], to_ned[1][0] * cell, to_ned[1][1] * cell, to_ned[1][2] * cell};
        look_along(row, fan, FLOAT(5), FLOAT(6), columns, at, ARRAY(double, 14) + i * columns);
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
   at most until something may have come from above or below, `above_s`; where something was received nothing is known. A
   cell is `cell_s` wide for what comes as fast as anything can. */
KERNEL(hold_empty, "rows out f8[rows,columns] until_s, u2[rows,columns] away, b1[rows,columns] received, "
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
