/* Levels that rise with the crests of the background around a place (`ThresholdRise` of rise.py). */

#ifndef ODS_RISE_H
#define ODS_RISE_H

#include "kernel.h"

/* The image is parted into places of so many beams and samples, (rows, columns) of them. */
typedef struct {
    double background;
    const double *factors; /* (rows, columns): how many times as high as those of speckle crests reach */
    double low_power, high_power;
    int64_t rows, columns, place_beams, place_samples;
} Rise;

/* What a kernel's signature says of it. */
#define RISE                                                                                                           \
    "float background, f8[across,along] factors, float low_power, float high_power, int place_beams, int place_samples"

/* arguments: from the first one on. Where there is no place, levels do not rise. */
static inline Rise rise_at(const Argument *arguments)
{
    static const double none = 1.0;
    if (SIZE(1, 0) * SIZE(1, 1) == 0)
        return (Rise){FLOAT(0), &none, 0.0, 0.0, 1, 1, 1, 1};
    return (Rise){FLOAT(0), ARRAY(const double, 1), FLOAT(2), FLOAT(3), SIZE(1, 0), SIZE(1, 1),
                  larger_i(INT(4), 1), larger_i(INT(5), 1)};
}

/* The level at each sample of each row of places, and the least of them. */
typedef struct {
    const float *of_rows; /* (rows, samples) */
    float least;
} Levels;

/* Returns a level risen by a power of the factors: what of it is over the background is multiplied. Exactly `level` where
   the factor is 1. */
static inline Levels risen(const Rise *rise, double level, double power, int64_t samples)
{
    float *levels = SCRATCH(float, rise->rows * samples), least = INFINITY;
    for (int64_t i = 0; i < rise->rows; i++)
        for (int64_t k = 0; k < rise->columns; k++) {
            const double factor = power == 0.0 ? 1.0 : pow(rise->factors[i * rise->columns + k], power);
            const float here = (float)(level + (level - rise->background) * (factor - 1.0));
            const int64_t begin = k * rise->place_samples;
            const int64_t end = k + 1 < rise->columns ? smaller_i(begin + rise->place_samples, samples) : samples;
            for (int64_t j = begin; j < end; j++)
                levels[i * samples + j] = here;
            least = smaller_f(here, least);
        }
    return (Levels){levels, least};
}

/* Returns the levels along a beam, (samples,). */
static inline const float *levels_along(const Rise *rise, Levels levels, int64_t beam, int64_t samples)
{
    return levels.of_rows + smaller_i(beam / rise->place_beams, rise->rows - 1) * samples;
}

#endif
