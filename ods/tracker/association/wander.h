/* How far a place's echoes wander along the range: a body against a spot (wander.py). */

#ifndef ODS_WANDER_H
#define ODS_WANDER_H

#include "kernel.h"

/* `LAW` of wander.py. */
typedef struct {
    double body_share, sure, most_for, most_in_crowd, most_against;
} WanderLaw;

/* Returns the log-likelihood ratio of a body over a spot by the sum of squares, m2, of so many echoes.

   Ranges are normal about the place; their variance is inverse gamma distributed, of `sure` degrees of freedom. */
static inline double evidence_of_wander(double squares, double echoes, double of_spots_m2, double crowd,
                                        const WanderLaw *law)
{
    const double body = square(law->body_share) * of_spots_m2, spot = of_spots_m2;
    const double more = log((law->sure * spot + squares) / (law->sure * body + squares));
    const double most = law->most_for + crowd * (law->most_in_crowd - law->most_for);
    const double ratio = 0.5 * (law->sure * log(body / spot) + (law->sure + echoes) * more);
    return smaller(most, larger(-law->most_against, ratio));
}

#endif
