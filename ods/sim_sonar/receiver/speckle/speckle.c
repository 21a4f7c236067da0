/* The normal numbers behind speckle (speckle.py has the theory): keys, with the cells of the sonar's pose that they are
   in, hashed and filtered. */

#include "ods/sim_sonar/receiver/speckle/random_field.h"

/* Steps in which a number's own borders are laid, and the bits that number them. */
#define OFFSETS 1024
#define OFFSET_BITS 10
/* What a cell along and across the beam, in heading and in time adds to a key. */
#define ALONG 0x85EBCA6Bu
#define ACROSS 0xC2B2AE35u
#define TURN 0x27D4EB2Fu
#define AGE 0x165667B1u
/* Cells across the beam beyond this are one: no sonar is so far away. */
#define FARTHEST_CELL 2.0e9f

/* In which cells of the sonar's pose one row of the field is, of 32 bits throughout, or the hash is three times slower.
   `next_`: in the next heading cell. */
typedef struct {
    uint32_t heading, next_heading;
    uint32_t turned; /* share of OFFSETS that is in the next heading cell */
    uint32_t along, next_along;
    float along_share, next_along_share;
    float across, next_across;
    uint32_t time;
    uint32_t young; /* share of OFFSETS from which on a number is in the next time cell */
} RowCells;

/* Returns one of a key's own places in a cell, 0 to 1. */
static inline float own_place(uint32_t key, int shift)
{
    return (float)(int32_t)((key >> shift) & (OFFSETS - 1)) * (1.0f / OFFSETS);
}

/* Sets `bits` to the hash of key and cells. Ten bits of a key each lay its own borders in heading, along, and across the
   beam; others in time. */
static void hash_row(const uint32_t *restrict keys, RowCells cells, const float *restrict nearness, int64_t count,
                     uint32_t *restrict bits)
{
    /* products that all numbers share are taken before: the loop is bound by its multiplications */
    const uint32_t first_cell = cells.along * ALONG + cells.heading * TURN + cells.time * AGE;
    const uint32_t next_cell = cells.next_along * ALONG + cells.next_heading * TURN + cells.time * AGE;
    for (int64_t j = 0; j < count; j++) {
        const uint32_t key = keys[j];
        const bool second = (key & (OFFSETS - 1)) < cells.turned;
        const uint32_t own_time = (key * 0x9E3779B1u) >> (32 - OFFSET_BITS);
        const float onward = (second ? cells.next_along_share : cells.along_share) + own_place(key, OFFSET_BITS);
        const float side = (second ? cells.next_across : cells.across) * nearness[j] + own_place(key, 2 * OFFSET_BITS);
        const float whole = larger_f(smaller_f(floorf(side), FARTHEST_CELL), -FARTHEST_CELL);
        const uint32_t across = (uint32_t)(int32_t)whole * ACROSS;
        const uint32_t along = onward >= 1.0f ? ALONG : 0, age = own_time >= cells.young ? AGE : 0;
        const uint32_t cell = (second ? next_cell : first_cell) + along + across + age;
        bits[j] = hash32(hash32(key + cell) ^ key);
    }
}

/* A pair of numbers: in a heading cell, and in the next one. */
typedef int64_t CellPair[2];
typedef float SharePair[2];

/* Returns the cells of one row of `Cells` of speckle.py, which are the nine arguments from number k on. */
static RowCells cells_of(const Argument *arguments, int k, int64_t row)
{
    const CellPair *along = ARRAY(const CellPair, k + 3);
    const SharePair *along_share = ARRAY(const SharePair, k + 4), *across = ARRAY(const SharePair, k + 5);
    return (RowCells){
        .heading = (uint32_t)INT(k),
        .next_heading = (uint32_t)INT(k + 1),
        .turned = (uint32_t)(FLOAT(k + 2) * OFFSETS),
        .along = (uint32_t)along[row][0],
        .next_along = (uint32_t)along[row][1],
        .along_share = along_share[row][0],
        .next_along_share = along_share[row][1],
        .across = across[row][0],
        .next_across = across[row][1],
        .time = (uint32_t)INT(k + 6),
        .young = (uint32_t)((1.0 - FLOAT(k + 7)) * OFFSETS),
    };
}

/* Samples [first, last) of all beams. */
typedef struct {
    int64_t first, last;
} Run;

/* Sets `runs` to the samples at which any beam receives an echo; gaps as short as `margin` are filled, as to begin anew
   costs more. Returns how many runs. */
static int64_t runs_received(const double *area, int64_t beams, int64_t samples, int64_t margin, Run *runs)
{
    double *most = ZEROS(double, samples);
    int64_t count = 0;
    for (int64_t beam = 0; beam < beams; beam++)
        for (int64_t j = 0; j < samples; j++)
            most[j] = larger(most[j], fabs(area[beam * samples + j]));
    for (int64_t j = 0; j < samples; j++) {
        if (most[j] == 0.0)
            continue;
        if (count == 0 || j - runs[count - 1].last > margin)
            runs[count++] = (Run){j, j};
        runs[count - 1].last = j + 1;
    }
    return count;
}

/* Adds the field of one sonar, `Scatterers`, in the cells of its pose, `Cells`, filtered in range and over the beams of
   each of its planes, to `out`, which is zero, at the ranges where there is an echo: `area`. */
LONG_KERNEL(fill_speckle,
            "u4[rows,width] keys, f4[width] nearness, " NORMAL_TABLE ", f4[:] range_taps, f4[:] beam_taps, int planes, "
            "int heading, int next_heading, float heading_share, i8[rows,2] along, f4[rows,2] along_share, "
            "f4[rows,2] across, int time, float time_share, f8[beams,samples] area, out f4[beams,samples] out")
{
    const int64_t width = SIZE(0, 1), range_taps = SIZE(3, 0), beam_taps = SIZE(4, 0), planes = larger_i(INT(5), 1);
    const int64_t rows = SIZE(0, 0) / planes, beams = SIZE(15, 0) / planes, samples = SIZE(15, 1);
    float *raw = SCRATCH(float, width), *smooth = SCRATCH(float, width), *out = ARRAY(float, 15);
    uint32_t *bits = SCRATCH(uint32_t, width);
    Run *runs = SCRATCH(Run, samples);
    const int64_t count = runs_received(ARRAY(double, 14), SIZE(15, 0), samples, range_taps, runs);
    for (int64_t r = 0; r < planes * rows; r++)
        for (int64_t k = 0; k < count; k++) {
            const int64_t first = runs[k].first, last = smaller_i(runs[k].last, width - range_taps + 1);
            if (first >= last)
                continue;
            const uint32_t *keys = ARRAY(uint32_t, 0) + r * width + first;
            hash_row(keys, cells_of(arguments, 6, r), ARRAY(float, 1) + first, last - first + range_taps - 1, bits);
            normals_of(bits, ARRAY(float, 2), last - first + range_taps - 1, raw);
            memset(smooth, 0, (size_t)(last - first) * sizeof *smooth);
            for (int64_t tap = 0; tap < range_taps; tap++)
                add_times(smooth, ARRAY(float, 3)[tap], raw + tap, last - first);
            for (int64_t tap = 0; tap < beam_taps; tap++) {
                const int64_t beam = r % rows - tap;
                if (0 <= beam && beam < beams)
                    add_times(out + (r / rows * beams + beam) * samples + first, ARRAY(float, 4)[tap], smooth, last - first);
            }
        }
}
