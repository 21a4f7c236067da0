/* Filters over pings: recursive mean and median, of images as they would look from where the vehicle is now. */

#include "kernel.h"

/* Stands, as all below 0 does, for an amplitude that a former ping does not tell. */
#define NOT_KNOWN -1.0f

/* Moves out, the former mean or below 0 where there is none, towards source by weight. */
KERNEL(blend, "f4[beams,samples] source, float weight, out f4[beams,samples] out")
{
    const float *restrict source = ARRAY(const float, 0);
    const float weight = (float)FLOAT(1);
    float *restrict out = ARRAY(float, 2);
    for (int64_t k = 0; k < SIZE(0, 0) * SIZE(0, 1); k++) {
        const float old = out[k] >= 0.0f ? out[k] : source[k];
        out[k] = old + weight * (source[k] - old);
    }
}

/* Sorts the known values of a cell into work, those of images that are `cells` apart, and returns how many they are. */
static int64_t sort_known(const float *first, int64_t cells, int64_t count, float *work)
{
    int64_t known = 0;
    for (int64_t k = 0; k < count; k++) {
        const float value = first[k * cells];
        if (value < 0.0f)
            continue;
        int64_t place = known++;
        for (; place > 0 && work[place - 1] > value; place--)
            work[place] = work[place - 1];
        work[place] = value;
    }
    return known;
}

/* Fills out with the (lower) median over the first `count` images of the stack, unknown ones left out. */
KERNEL(median_of_images, "f4[images,beams,samples] stack, int count, out f4[beams,samples] out")
{
    const int64_t cells = SIZE(0, 1) * SIZE(0, 2), count = smaller_i(INT(1), SIZE(0, 0));
    float *out = ARRAY(float, 2), *work = SCRATCH(float, SIZE(0, 0));
    for (int64_t j = 0; j < cells; j++) {
        const int64_t known = sort_known(ARRAY(const float, 0) + j, cells, count, work);
        out[j] = known > 0 ? work[(known - 1) / 2] : 0.0f;
    }
}

/* Places in an image, given at every `knot`th column. */
typedef struct {
    const double *column, *beam; /* (knots,) of one beam */
    int64_t knot, knots;
} Ways;

/* Fills columns `begin` to `stop` - 1 of a row from image (beams, samples): nearest beam, interpolated in range. */
static void resample_part(const float *image, int64_t beams, int64_t samples, Ways ways, int64_t k, float *out)
{
    const int64_t begin = k * ways.knot, end = begin + ways.knot;
    const int64_t stop = k == ways.knots - 2 ? samples : smaller_i(end, samples);
    const double length = (double)larger_i(1, smaller_i(end, samples - 1) - begin);
    const double beam_step = (ways.beam[k + 1] - ways.beam[k]) / length;
    const double column_step = (ways.column[k + 1] - ways.column[k]) / length;
    for (int64_t j = begin; j < stop; j++) {
        const double row = floor(ways.beam[k] + (double)(j - begin) * beam_step + 0.5);
        const double place = ways.column[k] + (double)(j - begin) * column_step;
        if (!(row >= 0.0 && row < (double)beams && place >= 0.0 && place < (double)samples)) {
            out[j] = NOT_KNOWN;
            continue;
        }
        const int64_t left = (int64_t)place;
        const float *near = image + (int64_t)row * samples + left;
        const float far = left + 1 < samples ? near[1] : near[0];
        out[j] = near[0] + (float)(place - (double)left) * (far - near[0]);
    }
}

/* Fills out with image at (beam, column), given at every `knot`th column; NOT_KNOWN where that is outside. */
KERNEL(resample, "f4[beams,samples] image, f8[beams,knots] column, f8[beams,knots] beam, int knot, "
                 "out f4[beams,samples] out")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), knots = SIZE(1, 1), knot = larger_i(INT(3), 1);
    for (int64_t b = 0; b < beams; b++) {
        const Ways ways = {ARRAY(const double, 1) + b * knots, ARRAY(const double, 2) + b * knots, knot, knots};
        float *out = ARRAY(float, 4) + b * samples;
        for (int64_t k = 0; k < knots - 1; k++)
            resample_part(ARRAY(const float, 0), beams, samples, ways, k, out);
    }
}
