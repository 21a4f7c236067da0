/* How sharply a place's echoes set in: a body against a spot (onset.py). */

#ifndef ODS_ONSET_H
#define ODS_ONSET_H

#include "kernel.h"

/* `LAW` of onset.py. */
typedef struct {
    double sharp, body_sharp, body_slow, spot_looks, most_for, most_against, enough;
} OnsetLaw;

static inline double log_beta(double a, double b)
{
    return lgamma(a) + lgamma(b) - lgamma(a + b);
}

/* Returns the log-likelihood ratio of a body over a spot by how many of so many echoes are sharp: beta-binomial. */
static inline double evidence_of_onset(double sharp, double echoes, double of_spots, const OnsetLaw *law)
{
    const double slow = echoes - sharp;
    const double body = log_beta(law->body_sharp + sharp, law->body_slow + slow) -
                        log_beta(law->body_sharp, law->body_slow);
    const double often = law->spot_looks * of_spots, seldom = law->spot_looks * (1.0 - of_spots);
    const double spot = log_beta(often + sharp, seldom + slow) - log_beta(often, seldom);
    const double least = echoes >= law->enough ? -law->most_against : 0.0;
    return smaller(law->most_for, larger(least, body - spot));
}

#endif
