/* Counts of spots, places where echoes come and go, by place in the fan and in the world (flicker.py). */

#include "kernel.h"

/* The world's cells are so large; after as many as there are they are used anew. */
#define CELL_M 2.0
/* A cell of the world with fewer tracks is forgotten. */
#define LEAST_TRACKS 0.01
/* Farther off than this, m, or at no number: the first cell. */
#define FARTHEST_PLACE_M 1e15

/* Counts are of spots, and of all tracks. */
enum { SPOTS, TRACKS };

/* `World` of flicker.py, after so many images; */
typedef struct {
    float *spots, *tracks;
    int64_t *image, cells, images;
    double memory, log_memory; /* what an image leaves of the counts of those before */
} World;

/* in a signature: four arguments. */
#define WORLD(OUT) OUT "f4[2,cells,cells] counts, " OUT "i8[cells,cells] image, int images, float memory"

/* Returns the world of the four arguments from number k on. */

static World world_from(const Argument *arguments, int k)
{
    const int64_t cells = SIZE(k + 1, 0);
    float *counts = ARRAY(float, k);
    return (World){.spots = counts,
                   .tracks = counts + cells * cells,
                   .image = ARRAY(int64_t, k + 1),
                   .cells = cells,
                   .images = INT(k + 2),
                   .memory = FLOAT(k + 3),
                   .log_memory = log(FLOAT(k + 3))};
}

/* `Places` of flicker.py, and the fan that they are in; */
typedef struct {
    const double *range_m, *bearing, *north, *east;
    double nearest, farthest, port, starboard;
    int64_t ranges, bearings;
} Places;

/* in a signature: eight arguments. */
#define PLACES \
    "f8[n] range_m, f8[n] bearing, f8[n] north, f8[n] east, float nearest, float farthest, float port, float starboard"

/* Returns the places of the eight arguments from number k on. */
static Places places_from(const Argument *arguments, int k, int64_t ranges, int64_t bearings)
{
    return (Places){.range_m = ARRAY(const double, k),
                    .bearing = ARRAY(const double, k + 1),
                    .north = ARRAY(const double, k + 2),
                    .east = ARRAY(const double, k + 3),
                    .nearest = FLOAT(k + 4),
                    .farthest = FLOAT(k + 5),
                    .port = FLOAT(k + 6),
                    .starboard = FLOAT(k + 7),
                    .ranges = ranges,
                    .bearings = bearings};
}

static int64_t class_of(double value, double first, double last, int64_t classes)
{
    const double share = (value - first) / (last - first);
    return share > 0.0 ? (int64_t)smaller(share * (double)classes, (double)classes - 1.0) : 0;
}

/* Returns which part of the fan place k is in. */
static int64_t part_of(const Places *places, int64_t k)
{
    const int64_t ring = class_of(places->range_m[k], places->nearest, places->farthest, places->ranges);
    return ring * places->bearings + class_of(places->bearing[k], places->port, places->starboard, places->bearings);
}

static int64_t cell_along(double metres, int64_t cells)
{
    const double place = fabs(metres) < FARTHEST_PLACE_M ? floor(metres / CELL_M) : 0.0;
    const int64_t cell = (int64_t)place % cells;
    return cell < 0 ? cell + cells : cell;
}

/* Returns which cell of the world place k is in. */
static int64_t cell_of(const Places *places, const World *world, int64_t k)
{
    return cell_along(places->north[k], world->cells) * world->cells + cell_along(places->east[k], world->cells);
}

/* Returns the share of its counts that is left of a cell's. */
static double kept(const World *world, int64_t cell)
{
    const double tracks = world->tracks[cell];
    const int64_t since = world->images - world->image[cell];
    if (since == 0 || tracks == 0.0)
        return 1.0;
    const double before = exp(((double)since - 1.0) * world->log_memory);
    return before * tracks > LEAST_TRACKS ? before * world->memory : 0.0;
}

/* Fills in numbers and counts of the cells that have any; returns how many these are. */
KERNEL_INT(flicker_left, WORLD("") ", out i4[all] numbers, out f4[2,all] left")
{
    const World world = world_from(arguments, 0);
    const int64_t most = SIZE(4, 0);
    int32_t *numbers = ARRAY(int32_t, 4);
    float *spots = ARRAY(float, 5), *tracks = spots + most;
    int64_t found = 0;
    for (int64_t cell = 0; cell < world.cells * world.cells && found < most; cell++) {
        const double share = world.tracks[cell] > 0.0f ? kept(&world, cell) : 0.0;
        if (share > 0.0) {
            numbers[found] = (int32_t)cell;
            spots[found] = (float)(world.spots[cell] * share);
            tracks[found] = (float)(world.tracks[cell] * share);
            found++;
        }
    }
    return found;
}

/* Adds what ended at n places: probabilities of spots, and of no objects. */
KERNEL(flicker_learn, "out f8[2,ranges,bearings] fan, " WORLD("out ") ", " PLACES ", f8[2,n] ended")
{
    const int64_t parts = SIZE(0, 1) * SIZE(0, 2), n = SIZE(5, 0);
    double *fan = ARRAY(double, 0);
    World world = world_from(arguments, 1);
    const Places places = places_from(arguments, 5, SIZE(0, 1), SIZE(0, 2));
    const double *ended = ARRAY(const double, 13);
    for (int64_t k = 0; k < n; k++) {
        const double tracks = ended[TRACKS * n + k], spots = smaller(tracks, ended[SPOTS * n + k]);
        if (tracks == 0.0)
            continue;
        const int64_t part = part_of(&places, k), cell = cell_of(&places, &world, k);
        const double share = kept(&world, cell);
        world.image[cell] = world.images;
        fan[SPOTS * parts + part] += spots;
        fan[TRACKS * parts + part] += tracks;
        world.spots[cell] = (float)(share * world.spots[cell] + spots);
        world.tracks[cell] = (float)(share * world.tracks[cell] + tracks);
    }
}

/* Returns the share of spots in a part, by its own counts and by the share in the larger part. */
static double pooled(double spots, double tracks, double in_larger, double weight)
{
    return (spots + weight * in_larger) / (tracks + weight);
}

static double sum_of(const double *values, int64_t count)
{
    double sum = 0.0;
    for (int64_t k = 0; k < count; k++)
        sum += values[k];
    return sum;
}

/* Fills in the share of spots among echoes of nothing at n places, not above `most`.

   `prior`: share where nothing is known, which counts for `calm_tracks` in the image as a whole; that of a larger part
   counts for `pooled_tracks` in a smaller one. */
KERNEL(flicker_share,
       "float prior, float calm_tracks, float pooled_tracks, float most, out f8[n] share, "
       "f8[2,ranges,bearings] fan, " WORLD("") ", " PLACES)
{
    const int64_t ranges = SIZE(5, 1), bearings = SIZE(5, 2), parts = ranges * bearings, n = SIZE(4, 0);
    const double *spots = ARRAY(const double, 5), *tracks = spots + parts;
    const World world = world_from(arguments, 6);
    const Places places = places_from(arguments, 10, ranges, bearings);
    const double prior = FLOAT(0), weight = FLOAT(2), most = FLOAT(3);
    double *share = ARRAY(double, 4), *in_ring = SCRATCH(double, ranges);
    const double whole = pooled(sum_of(spots, parts), sum_of(tracks, parts), prior, FLOAT(1));
    for (int64_t ring = 0; ring < ranges; ring++)
        in_ring[ring] = pooled(sum_of(spots + ring * bearings, bearings), sum_of(tracks + ring * bearings, bearings),
                               whole, weight);
    for (int64_t k = 0; k < n; k++) {
        const int64_t part = part_of(&places, k), cell = cell_of(&places, &world, k);
        const double in_fan = pooled(spots[part], tracks[part], in_ring[part / bearings], weight);
        const double left = kept(&world, cell);
        share[k] = smaller(most, pooled(left * world.spots[cell], left * world.tracks[cell], in_fan, weight));
    }
}
