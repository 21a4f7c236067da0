/* Cuts large regions into pieces that stay where they are as the sonar moves (pieces.py). */

#include "ods/pipeline/image/fan.h"
#include "ods/pipeline/image/regions.h"

typedef double TurnRow[3];

/* Squares of the world, and from where a fan sees them. */
typedef struct {
    const FanTable *fan;
    const double *position; /* of the head, (3,) NED, m */
    const TurnRow *turned;  /* head to global, (3, 3) */
    double side_m;
} World;

/* A square: how many sides it is north and east of the origin. */
typedef struct {
    double north, east; /* whole numbers */
} Square;

/* The squares in which the region that is being cut lies. */
typedef struct {
    Square *squares;
    int64_t count;
} Squares;

/* Returns the number of a square among those of the region, which it may be new to. */
static int64_t number_of(Squares *known, Square square)
{
    for (int64_t k = known->count - 1; k >= 0; k--) /* a neighbour is mostly in one of the last */
        if (known->squares[k].north == square.north && known->squares[k].east == square.east)
            return k;
    known->squares[known->count] = square;
    return known->count++;
}

/* Fills out with the parts of a run in different squares, which are numbered after `before`; returns how many. */
static int64_t cut_run(Run run, const World *world, Squares *known, int64_t before, Run *out)
{
    const FanTable *fan = world->fan;
    const double level = cos(fan->elevation_rad), bearing = fan->bearing_rad[run.beam];
    const double body[3] = {level * cos(bearing), level * sin(bearing), -sin(fan->elevation_rad)};
    double sight[2] = {0.0, 0.0};
    for (int axis = 0; axis < 2; axis++)
        for (int i = 0; i < 3; i++)
            sight[axis] += world->turned[axis][i] * body[i];
    int64_t parts = 0;
    for (int32_t j = run.first; j < run.stop; j++) {
        const double range_m = fan->range0_m + (double)j * fan->dr_m;
        const Square square = {floor((world->position[0] + range_m * sight[0]) / world->side_m),
                               floor((world->position[1] + range_m * sight[1]) / world->side_m)};
        const int32_t number = (int32_t)(before + 1 + number_of(known, square));
        if (parts > 0 && out[parts - 1].region == number)
            out[parts - 1].stop = j + 1;
        else
            out[parts++] = (Run){run.beam, j, j + 1, number};
    }
    return parts;
}

/* Cuts the `large` regions of runs in order: fills out with the runs of all, numbered anew and in order, and `whole`
   with the region, from 0, that each of the new ones is of. Returns how many runs there are; `room`: cells in all. */
KERNEL_INT(cut_regions, "r16[runs] runs, b1[total] large, " FAN_TABLE ", f8[3] position, f8[3,3] turned, float side_m, "
                        "out r16[room] out, out i8[room] whole")
{
    const Run *runs = ARRAY(const Run, 0), *end = runs + SIZE(0, 0);
    const bool *large = ARRAY(const bool, 1);
    const int64_t room = SIZE(11, 0);
    const FanTable fan = fan_table_at(arguments + 2);
    const World world = {&fan, ARRAY(const double, 8), ARRAY(const TurnRow, 9), FLOAT(10)};
    int64_t *whole = ARRAY(int64_t, 12), count = 0, numbered = 0;
    Run *cut = SCRATCH(Run, room);
    Squares known = {SCRATCH(Square, room), 0};
    while (runs < end) {
        const int32_t region = runs->region;
        known.count = 0;
        for (; runs < end && runs->region == region; runs++) {
            if (large[region - 1]) {
                count += cut_run(*runs, &world, &known, numbered, cut + count);
                continue;
            }
            known.count = 1;
            cut[count] = *runs;
            cut[count++].region = (int32_t)numbered + 1;
        }
        for (int64_t k = 0; k < known.count; k++)
            whole[numbered++] = region - 1;
    }
    sorted_runs(cut, count, ARRAY(Run, 11));
    return count;
}
