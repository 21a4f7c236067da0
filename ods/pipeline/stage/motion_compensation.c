/* Images of earlier pings as they would look from where the vehicle is now: see motion_compensation.py. */

#include "kernel.h"

/* Places in an image, given at every `knot`th column. */
typedef struct {
    const double *column, *beam; /* (knots,) of one beam */
    int64_t knot, knots;
} Ways;

/* Fills columns `begin` to `stop` - 1 of a row from image (beams, samples): nearest beam, interpolated in range. */
static void resample_part(const float *image, int64_t beams, int64_t samples, Ways ways, int64_t k, float unknown, float *out)
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
            out[j] = unknown;
            continue;
        }
        const int64_t left = (int64_t)place;
        const float *near = image + (int64_t)row * samples + left;
        const float far = left + 1 < samples ? near[1] : near[0];
        out[j] = near[0] + (float)(place - (double)left) * (far - near[0]);
    }
}

/* Fills out with image at (beam, column), given at every `knot`th column; `unknown` where that is outside. */
KERNEL(resample, "f4[beams,samples] image, f8[beams,knots] column, f8[beams,knots] beam, int knot, float unknown, "
                 "out f4[beams,samples] out")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), knots = SIZE(1, 1), knot = larger_i(INT(3), 1);
    for (int64_t b = 0; b < beams; b++) {
        const Ways ways = {ARRAY(const double, 1) + b * knots, ARRAY(const double, 2) + b * knots, knot, knots};
        float *out = ARRAY(float, 5) + b * samples;
        for (int64_t k = 0; k < knots - 1; k++)
            resample_part(ARRAY(const float, 0), beams, samples, ways, k, (float)FLOAT(4), out);
    }
}
