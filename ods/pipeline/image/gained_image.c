/* An image with its gain applied. */

#include "ods/pipeline/image/gained_image.h"

/* Fills out with the amplitudes. */
KERNEL(write_image, GAINED_IMAGE ", out f4[beams,samples] out")
{
    const GainedImage image = gained_image_at(arguments);
    float *out = ARRAY(float, arguments_of(GAINED_IMAGE));
    for (int64_t b = 0; b < image.beams; b++)
        load_row(image, b, out + b * image.samples);
}
