/* What a stage reads: an image with a gain that is still to be applied (`GainedImage` of gained_image.py).

       KERNEL(median_filter, GAINED_IMAGE ", int half, out f4[beams,samples] out")
       {
           const GainedImage image = gained_image_at(arguments);
           const int64_t half = INT(arguments_of(GAINED_IMAGE));
           float *out = ARRAY(float, arguments_of(GAINED_IMAGE) + 1); */

#ifndef ODS_GAINED_IMAGE_H
#define ODS_GAINED_IMAGE_H

#include "kernel.h"
#include "ods/pipeline/filter/rows/padding.h"
#include "ods/pipeline/image/samples/samples.h"

/* An image of (beams, samples) amplitudes: (cells[b, first + j] + offset) * gain at b, j.
   The gain of beam b is of_beam[b] times that of row above[b], moved by share[b] towards the next row's. */
typedef struct {
    int64_t beams, samples;
    Samples cells; /* (beams, first + samples) */
    int64_t first;
    float offset;
    const float *gain; /* (rows, samples) */
    const int64_t *above;
    const float *share; /* 0 to 1; 0 for the last row */
    const float *of_beam;
    bool plain; /* the gain is 1 everywhere */
} GainedImage;

/* What a kernel's signature says of it. */
#define GAINED_IMAGE                                                                                                   \
    "rows u1|u2|f4[beams,:] cells, int first, float offset, f4[:,samples] gain, i8[beams] above, f4[beams] share, "     \
    "f4[beams] of_beam, bool plain"

/* arguments: from the image's first one on. */
static inline GainedImage gained_image_at(const Argument *arguments)
{
    return (GainedImage){SIZE(0, 0), SIZE(3, 1), SAMPLES(0), INT(1), (float)FLOAT(2), ARRAY(const float, 3),
                         ARRAY(const int64_t, 4), ARRAY(const float, 5), ARRAY(const float, 6), BOOL(7)};
}

/* What load_row and add_row do for cells of one type; PUT: = or +=. */
#define PUT_CELLS(TYPE, PUT)                                                                                           \
    {                                                                                                                  \
        const TYPE *restrict source = (const TYPE *)cells + image.first;                                               \
        if (weight == 0.0f)                                                                                            \
            for (int64_t j = 0; j < image.samples; j++)                                                                \
                out[j] PUT ((float)source[j] + offset) * factor * near[j];                                             \
        else                                                                                                           \
            for (int64_t j = 0; j < image.samples; j++)                                                                \
                out[j] PUT ((float)source[j] + offset) * factor * (near[j] + weight * (far[j] - near[j]));             \
        break;                                                                                                         \
    }
#define PUT_ROW(PUT)                                                                                                   \
    {                                                                                                                  \
        const char *cells = image.cells.data + beam * image.cells.row_bytes;                                           \
        const float *restrict near = image.gain + image.above[beam] * image.samples;                                   \
        const float *restrict far = near + image.samples;                                                              \
        const float offset = image.offset, weight = image.share[beam], factor = image.of_beam[beam];                   \
        switch (image.cells.type) {                                                                                    \
        case 'B':                                                                                                      \
            PUT_CELLS(uint8_t, PUT)                                                                                    \
        case 'H':                                                                                                      \
            PUT_CELLS(uint16_t, PUT)                                                                                   \
        default:                                                                                                       \
            PUT_CELLS(float, PUT)                                                                                      \
        }                                                                                                              \
    }

/* Fills out (samples,) with one beam's amplitudes. */
static inline void load_row(GainedImage image, int64_t beam, float *restrict out)
{
    PUT_ROW(=)
}

/* Adds one beam's amplitudes to out (samples,). */
static inline void add_row(GainedImage image, int64_t beam, float *restrict out)
{
    PUT_ROW(+=)
}

/* Fills padded (samples + 2 half,) with one beam's amplitudes and `half` mirrored ones at both ends. */
static inline void load_mirrored(GainedImage image, int64_t beam, int64_t half, float *restrict padded)
{
    load_row(image, beam, padded + half);
    mirror_ends(padded, half, image.samples);
}

#endif
