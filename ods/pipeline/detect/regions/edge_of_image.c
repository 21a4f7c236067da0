/* Echoes at the image's border: which regions are strong enough there (grouping.py). */

#include "ods/pipeline/detect/regions/inside.h"
#include "ods/pipeline/detect/background/rise.h"

/* Width of the border, cells: that of the default filter's half window. */
#define BORDER_BEAMS 2
#define BORDER_SAMPLES 4
/* An image of fewer has no such border: it would be all border. */
#define LEAST_BEAMS 16
#define LEAST_SAMPLES 64

/* Tells which regions have a cell above `high` that is not in the border, or one above `raised`; both rise as the low
   level does. */
KERNEL(strong_at_border, "f4[beams,samples] image, r16[runs] runs, float high, float raised, " RISE
                         ", out b1[regions] strong")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), regions = SIZE(4 + arguments_of(RISE), 0);
    const Rise rise = rise_at(arguments + 4);
    const int64_t lower = beams >= LEAST_BEAMS ? BORDER_BEAMS : 0, near = samples >= LEAST_SAMPLES ? BORDER_SAMPLES : 0;
    const Levels inside = risen(&rise, FLOAT(2), rise.low_power, samples);
    const Levels raised = risen(&rise, FLOAT(3), rise.low_power, samples);
    bool *strong = ARRAY(bool, 4 + arguments_of(RISE));
    memset(strong, false, (size_t)regions);
    for (int64_t i = 0; i < SIZE(1, 0); i++) {
        const Run run = ARRAY(const Run, 1)[i];
        if (!lies_inside(run, beams, samples, regions))
            continue;
        const float *cells = ARRAY(const float, 0) + run.beam * samples;
        const bool outer = run.beam < lower || run.beam >= beams - lower;
        const float *levels = levels_along(&rise, inside, run.beam, samples);
        const float *higher = levels_along(&rise, raised, run.beam, samples);
        for (int64_t j = run.first; j < run.stop && !strong[run.region - 1]; j++)
            strong[run.region - 1] = cells[j] > (outer || j < near || j >= samples - near ? higher : levels)[j];
    }
}
