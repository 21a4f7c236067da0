/* The onset of one echo, as Python asks for it. */

#include "ods/pipeline/measure/onset.h"

KERNEL_FLOAT(onset_of, "f4[beams,columns] image, r16[runs] runs, float point")
{
    Region region = {.image = ARRAY(const float, 0), .beams = SIZE(0, 0), .columns = SIZE(0, 1),
                     .runs = ARRAY(const Run, 1), .count = SIZE(1, 0)};
    return is_within(&region) ? onset_of_region(&region, FLOAT(2)) : 0.0;
}
