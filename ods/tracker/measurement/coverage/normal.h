/* The standard normal distribution. */

#ifndef ODS_NORMAL_H
#define ODS_NORMAL_H

#include "kernel.h"

/* A difference of more standard deviations than this is not by chance. */
#define BEYOND_CHANCE 3.0
/* Allows for rounding. */
#define ROUNDED (1.0 + 1e-9)

static inline double length_of(double a, double b)
{
    return sqrt(a * a + b * b);
}

/* Returns the probability of less than `deviate` standard deviations. */
static inline double normal_below(double deviate)
{
    return 0.5 * erfc(deviate * -0.70710678118654752440);
}

#endif
