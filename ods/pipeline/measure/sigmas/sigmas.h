/* How well an echo's circle is known: standard deviations as fitted to known bodies' errors.

   A law is a smooth function of two layers, the first of which saturates: beyond what it was fitted to it stays finite.
   benchmarks/circles/laws.py fits them: one of near edge, radius and place across, one of the range. */

#ifndef ODS_SIGMAS_H
#define ODS_SIGMAS_H

#include "ods/pipeline/measure/region.h"

/* Standard deviation of what is rounded to whole columns, in columns: no place along the line of sight or across it is
   claimed to be known better. */
#define ROUNDING sqrt(1.0 / 12.0)
/* Logarithms of standard deviations in widths of a point that the law may claim. */
#define LEAST_LOG -3.0
#define MOST_LOG 5.0
/* A place at the sonar itself has some bearing, too. */
#define NEAREST_M 1e-3

/* Its factors, the last row of each the constants. */
typedef struct {
    const double *hidden; /* (inputs + 1, width); of the first features */
    const double *out;    /* (width + 1, outputs) */
    int64_t inputs, width, outputs;
} Law;

typedef struct {
    Law sigmas, range;
} Laws;

/* What a signature says of both. */
#define LAWS "f8[:,:] sigmas_hidden, f8[:,3] sigmas_out, f8[:,:] range_hidden, f8[:,1] range_out"

/* Standard deviations. */
typedef struct {
    double near_m, range_m, radius_m, bearing_rad;
} Sigmas;

/* arguments: its two arrays. */
static inline Law law_at(const Argument *arguments)
{
    return (Law){ARRAY(const double, 0), ARRAY(const double, 1), SIZE(0, 0) - 1, SIZE(0, 1), SIZE(1, 1)};
}

/* Whether a law's factors fit one another, and so many features. */
static inline bool fits(Law law, const Argument *arguments, int64_t features)
{
    return 0 <= law.inputs && law.inputs <= features && SIZE(1, 0) == law.width + 1;
}

/* arguments: from the first one on. */
static inline Laws laws_at(const Argument *arguments)
{
    return (Laws){law_at(arguments), law_at(arguments + 2)};
}

/* Returns tanh(x), right to 1e-12: e^2x is (e^(2x / 256))^256, and of that the Taylor series is short. Unlike a call of
   tanh, the compiler turns it into vector instructions. */
static inline double saturated(double x)
{
    const double t = held(x, -20.0, 20.0) / 128.0;
    double power = 1.0;
    for (int k = 9; k > 0; k--)
        power = 1.0 + power * t / k;
    for (int k = 0; k < 8; k++)
        power *= power;
    return 1.0 - 2.0 / (power + 1.0);
}

/* Fills sums (outputs,) with the logarithms of the variances, in widths of a point. */
static inline void find_outputs(const double *features, Law law, double *sums)
{
    const int64_t width = law.width;
    double *totals = SCRATCH(double, width);
    memcpy(totals, law.hidden + law.inputs * width, (size_t)width * sizeof *totals);
    for (int64_t i = 0; i < law.inputs; i++)
        for (int64_t j = 0; j < width; j++)
            totals[j] += features[i] * law.hidden[i * width + j];
    memcpy(sums, law.out + width * law.outputs, (size_t)law.outputs * sizeof *sums);
    for (int64_t j = 0; j < width; j++)
        totals[j] = saturated(totals[j]);
    for (int64_t j = 0; j < width; j++)
        for (int64_t k = 0; k < law.outputs; k++)
            sums[k] += totals[j] * law.out[j * law.outputs + k];
}

/* Returns the standard deviation, m, by the law for the logarithm of its variance, in widths of a point. */
static inline double sigma_m(double log_variance, double point_m, double least)
{
    const double logarithm = 0.5 * log_variance;
    return larger(least, point_m * exp(smaller(MOST_LOG, larger(LEAST_LOG, logarithm))));
}

/* Returns the standard deviations of an echo of these features.

   point_m: width of a point along the line of sight; beside_m: the largest across it; dr_m: the columns' spacing. */
static inline Sigmas sigmas_of_features(const double *features, const Laws *laws, double point_m, double beside_m,
                                        double range_m, double dr_m)
{
    double log_variances[3], along[1];
    find_outputs(features, laws->sigmas, log_variances);
    find_outputs(features, laws->range, along);
    const double least = ROUNDING * dr_m;
    const double across = larger(least, smaller(beside_m, sigma_m(log_variances[2], point_m, least)));
    return (Sigmas){
        .near_m = sigma_m(log_variances[0], point_m, least), .range_m = sigma_m(along[0], point_m, least),
        .radius_m = sigma_m(log_variances[1], point_m, least), .bearing_rad = across / larger(NEAREST_M, range_m),
    };
}

#endif
