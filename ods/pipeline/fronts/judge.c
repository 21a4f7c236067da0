/* The recorded samples around where an echo sets in, as levels (judge.py). */

#include <float.h>

#include "ods/pipeline/image/samples/decibels.h"
#include "ods/pipeline/image/samples/samples.h"

/* Of a window's mean amplitude, added to each, so that none is not infinitely below its surroundings. */
#define LEAST 0.01f

static int64_t clipped(int64_t index, int64_t size)
{
    return smaller_i(larger_i(index, 0), size - 1);
}

/* Returns the number of the beam that is nearest to a bearing. */
static int64_t nearest_beam(const double *bearing_rad, int64_t beams, double wanted_rad)
{
    int64_t nearest = 0;
    for (int64_t b = 1; b < beams; b++)
        if (fabs(bearing_rad[b] - wanted_rad) < fabs(bearing_rad[nearest] - wanted_rad))
            nearest = b;
    return nearest;
}

/* Copies samples of a row from `first` on, of so many bytes; beyond the row they are as the nearest that it has. */
static void copy_around(const char *row, int64_t samples, int64_t bytes, int64_t first, int64_t count, char *out)
{
    const int64_t begin = clipped(first, samples), stop = larger_i(smaller_i(first + count, samples), begin + 1);
    const int64_t before = smaller_i(larger_i(begin - first, 0), count);
    const int64_t inside = larger_i(smaller_i(stop - begin, count - before), 0);
    for (int64_t j = 0; j < before; j++)
        memcpy(out + j * bytes, row + begin * bytes, (size_t)bytes);
    memcpy(out + before * bytes, row + begin * bytes, (size_t)(inside * bytes));
    for (int64_t j = before + inside; j < count; j++)
        memcpy(out + j * bytes, row + (samples - 1) * bytes, (size_t)bytes);
}

/* Fills out with the recorded samples around places (bearing, sample), `before` of them before it, and in as many beams
   around it as there are rows, each `strides` of the nearest beam from the one before. */
KERNEL(cut_windows, "rows u1|u2|f4[beams,:] samples, f8[beams] bearing_rad, i8[beams] strides, f8[places,2] places, "
                    "int before, out u1|u2|f4[places,rows,:] out")
{
    const Samples samples = SAMPLES(0);
    const int64_t beams = SIZE(0, 0), rows = SIZE(5, 1), count = SIZE(5, 2), bytes = sample_bytes(samples.type);
    if (TYPE(5) != samples.type || beams == 0 || samples.samples == 0)
        return;
    for (int64_t k = 0; k < SIZE(3, 0); k++) {
        const double *place = ARRAY(const double, 3) + 2 * k;
        const double inside = larger(smaller(place[1], (double)(samples.samples + count)), (double)-count);
        const int64_t first = (int64_t)inside - INT(4);
        const int64_t beam = nearest_beam(ARRAY(const double, 1), beams, place[0]);
        const int64_t stride = ARRAY(const int64_t, 2)[beam];
        for (int64_t i = 0; i < rows; i++)
            copy_around(samples.data + clipped(beam + (i - rows / 2) * stride, beams) * samples.row_bytes, samples.samples, bytes, first,
                        count, ARRAY(char, 5) + (k * rows + i) * count * bytes);
    }
}

/* Turns the amplitudes of windows into levels, dB over the mean level of each; 0 where there is nothing at all. */
KERNEL(level_windows, "out f4[windows,beams,cells] windows")
{
    const int64_t cells = SIZE(0, 1) * SIZE(0, 2);
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        float *restrict window = ARRAY(float, 0) + k * cells;
        float total = 0.0f, sum = 0.0f;
        for (int64_t j = 0; j < cells; j++)
            total += window[j];
        const float scale = 1.0f / larger_f(total / (float)cells, FLT_MIN);
        for (int64_t j = 0; j < cells; j++) {
            window[j] = decibels(window[j] * scale + LEAST);
            sum += window[j];
        }
        for (int64_t j = 0; j < cells; j++)
            window[j] -= sum / (float)cells;
    }
}
