/* How strong a place's echoes are: a body against echoes of nothing (strength.py). */

#ifndef ODS_STRENGTH_H
#define ODS_STRENGTH_H

#include "kernel.h"

/* The rows of the table of `Typical`: the echoes of nothing, at n places. */
typedef struct {
    double *mean_db, *sigma_db, *known;
} Typical;

/* Names the rows of a (3, count) table: `f8[3,n]` in signatures. */
static inline Typical typical_rows(double *table, int64_t count)
{
    return (Typical){table, table + count, table + 2 * count};
}

/* `LAW` of strength.py. */
typedef struct {
    double lasting, span_db, most;
} StrengthLaw;

/* Returns the log-likelihood ratio of a body over nothing that the mean strength of its echoes gives.

   excess: mean of (strength - mean) / sigma of so many `echoes`; `sigma_db`, `known`: as in `Typical`. Highlights
   follow the logistic law, whose tail falls as slowly as an exponential; what is no stronger than they are on average
   is taken to be at their mean. */
static inline double evidence_of_strength(double excess, double echoes, double sigma_db, double known,
                                          const StrengthLaw *law)
{
    if (echoes == 0.0)
        return 0.0;
    /* pi / sqrt(3): standard deviation of the logistic law of scale 1 */
    const double scale = sqrt(law->lasting + (1.0 - law->lasting) / larger(1.0, echoes)) / 1.8137993642342178;
    const double over = larger(0.0, excess) / scale;
    const double of_highlight = -over - 2.0 * log1p(exp(-over)) - log(scale * sigma_db);
    return smaller(law->most, larger(-law->most, known * (-log(law->span_db) - of_highlight)));
}

#endif
