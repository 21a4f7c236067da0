/* How a place's last echoes set in by the chain's judgement: a body against a spot (front.py). */

#ifndef ODS_FRONT_H
#define ODS_FRONT_H

#include "kernel.h"

/* What an echo leaves of those before: a place is judged by the last seven. */
#define FRONT_FADE 0.85

/* `LAW` of front.py. */
typedef struct {
    double sure, body, variance, few, most_for, most_against;
} FrontLaw;

/* Returns the logarithm of the odds of a front as `Detection` tells it. */
static inline double log_odds_of_front(double front, const FrontLaw *law)
{
    const double share = smaller(1.0 - law->sure, larger(law->sure, front));
    return log(share / (1.0 - share));
}

/* Returns the log-likelihood ratio of a body over a spot by the sum of the log-odds of so many echoes: normal. */
static inline double evidence_of_front(double total, double echoes, double of_spots, const FrontLaw *law)
{
    const double over = total - 0.5 * (law->body + of_spots) * echoes;
    const double ratio = (law->body - of_spots) * over / (law->variance * (echoes + law->few));
    return smaller(law->most_for, larger(-law->most_against, ratio));
}

#endif
