/* The width of a point in an image, by how speckle is correlated along the beams. */

#include "ods/pipeline/measure/response.h"

double width_of_point(const float *image, int64_t beams, int64_t columns, double background)
{
    const int64_t step = larger_i(1, beams * (columns - 1) / PAIRS);
    const float most = (float)(SPECKLE * background);
    const int64_t room = beams * (columns / step + 1);
    float *restrict near = SCRATCH(float, room), *restrict far = SCRATCH(float, room);
    double total = 0.0, squares = 0.0, products = 0.0;
    int64_t seen = 0, count = 0;
    for (int64_t beam = 0; beam < beams; beam++)
        for (int64_t j = beam * columns + beam % step; j < (beam + 1) * columns - 1; j += step) {
            near[seen] = image[j];
            far[seen++] = image[j + 1];
        }
    for (int64_t i = 0; i < seen; i++) {
        const float x = near[i], y = far[i];
        const bool quiet = (0.0f < x) & (x < most) & (0.0f < y) & (y < most);
        count += quiet;
        total += quiet ? x + y : 0.0f;
        squares += quiet ? x * x + y * y : 0.0f;
        products += quiet ? x * y : 0.0f;
    }
    if (count == 0)
        return LEAST_POINT;
    const double mean = 0.5 * total / (double)count;
    const double variance = 0.5 * squares / (double)count - mean * mean;
    const double shared = products / (double)count - mean * mean;
    if (variance < LEAST_VARIANCE * background * background || shared <= 0.0)
        return LEAST_POINT;
    return larger(LEAST_POINT, FULL_WIDTH * 0.5 / sqrt(larger(1e-4, -log(smaller(1.0, shared / variance)))));
}

/* Returns how many times as much cells two columns apart differ as neighbours, mean squares, in a stretch of a beam;
   0: not known. */
static double growth(const float *row, float most)
{
    float near = 0.0f, far = 0.0f;
    int32_t count = 0;
    for (int32_t j = 0; j < STRETCH - 2; j++) {
        const float x = row[j], y = row[j + 1], z = row[j + 2];
        const bool quiet = (0.0f < x) & (x < most) & (0.0f < y) & (y < most) & (0.0f < z) & (z < most);
        near += quiet ? (y - x) * (y - x) + (z - y) * (z - y) : 0.0f;
        far += quiet ? (z - x) * (z - x) : 0.0f;
        count += quiet;
    }
    return near > 0.0f && 2 * count > STRETCH ? (double)(2.0f * far / near) : 0.0;
}

/* Returns q of 1 + q + q^2 + q^3 = ratio, by Newton: the sum is convex and grows, so from 1 on it converges. */
static double root(double ratio)
{
    double q = 1.0;
    for (int k = 0; k < 8; k++)
        q -= (1.0 + q * (1.0 + q * (1.0 + q)) - ratio) / (1.0 + q * (2.0 + 3.0 * q));
    return larger(q, 0.0);
}

/* Returns the value of which `rank` others are smaller; the values change places (C. A. R. Hoare, Commun. ACM 4(7),
   1961). */
static double ranked(double *values, int64_t count, int64_t rank)
{
    int64_t first = 0, last = count - 1;
    while (first < last) {
        const double middle = values[rank];
        int64_t i = first, j = last;
        while (i <= j) {
            while (values[i] < middle)
                i++;
            while (values[j] > middle)
                j--;
            if (i <= j) {
                const double value = values[i];
                values[i++] = values[j], values[j--] = value;
            }
        }
        first = j < rank ? i : first;
        last = i > rank ? j : last;
    }
    return values[rank];
}

double width_of_response(const float *image, int64_t beams, int64_t columns, double background)
{
    const float most = (float)(SPECKLE * background);
    double *ratios = SCRATCH(double, (beams / EVERY_BEAM + 1) * (columns / STRETCH));
    int64_t count = 0;
    for (int64_t beam = EVERY_BEAM / 2; beam < beams; beam += EVERY_BEAM)
        for (int64_t first = 0; first <= columns - STRETCH; first += STRETCH) {
            ratios[count] = growth(image + beam * columns + first, most);
            count += ratios[count] > 0.0;
        }
    if (count == 0)
        return 0.0;
    const double measured = ranked(ratios, count, (int64_t)(LEAST_SHARE * (double)count));
    const double shared = root(smaller(WIDEST, larger(1.0, measured)));
    return larger(LEAST_POINT, FULL_WIDTH * 0.5 / sqrt(-log(shared)));
}
