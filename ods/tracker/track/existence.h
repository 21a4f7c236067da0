/* Does an object exist? The chain of hidden states of one object (existence.py has what it is). */

#ifndef ODS_EXISTENCE_H
#define ODS_EXISTENCE_H

#include "kernel.h"

/* An object seen once is lost so many times sooner than an old one; the excess falls with the number of echoes. */
#define YOUNG 300.0
/* Keeps quotients and logarithms of a probability finite. */
#define SMALLEST 1e-300
/* No echo is that sure. */
#define LEAST_MISSED 1e-3
/* Largest log-likelihood ratio of one echo; e^30 leaves nothing of any doubt. */
#define MOST_EVIDENCE 30.0

/* Probabilities of the four states of one object. */
typedef struct {
    double visible, silent, nothing, spot;
} Chain;

/* How often an object falls silent, gives echoes again, and is lost: 1/s each. */
typedef struct {
    double silence, recovery, loss;
} Rates;

/* How often an object has an echo, if it is a body and if it is a spot, over the setting's. */
typedef struct {
    double body, spot;
} Often;

/* `SEEN` of existence.py. */
typedef struct {
    double body_seen, body_looks, spot_seen, spot_looks, spot_looks_in_crowd;
} Seen;

static inline Chain normalized(double visible, double silent, double nothing, double spot)
{
    const double total = visible + silent + nothing + spot;
    return (Chain){visible / total, silent / total, nothing / total, spot / total};
}

/* Returns the probabilities `dt` seconds later.

   `watched`: share of the time that the object was in the sonar's view: only there does it fall silent or come back.
   `echoes`: so far; a young object is more often an error of association, and in view is lost sooner. */
static inline Chain carried_on(Chain chain, int64_t echoes, double watched, double dt, Rates rates)
{
    const double time = dt * watched;
    const double falls_silent = chain.visible * -expm1(-rates.silence * time);
    const double returns = chain.silent * -expm1(-rates.recovery * time);
    const double lost = -expm1(-rates.loss * (dt + time * YOUNG / (double)echoes));
    const double moved = returns - falls_silent;
    return (Chain){(1.0 - lost) * (chain.visible + moved), (1.0 - lost) * (chain.silent - moved),
                   chain.nothing + lost * (chain.visible + chain.silent), chain.spot};
}

/* Returns how often an object has an echo, by its echoes in so many looks.

   What is not known beforehand is what an image's echo, or its absence, says by the beta distribution: a spot that is
   seen again and again is one that is seen often, and each further echo proves less. `crowd`: of `doubt.Spots`. */
static inline Often how_often(double hits, double looks, double detection_probability, double crowd, const Seen *seen)
{
    const double body = (hits + seen->body_looks * seen->body_seen) / (looks + seen->body_looks);
    const double spots_looks = seen->spot_looks + crowd * (seen->spot_looks_in_crowd - seen->spot_looks);
    const double spot = (hits + spots_looks * seen->spot_seen) / (looks + spots_looks);
    return (Often){body / detection_probability, spot / detection_probability};
}

static inline double likelihood(double often, double expected, double weight)
{
    return larger(LEAST_MISSED, 1.0 - expected * often) + weight * often;
}

/* Returns the probabilities after an image.

   `llr`: logarithm of the likelihood of an echo from the object over that of a false alarm, used where `hit`;
   `expected`: probability that a visible object would have given an echo. To a silent object, and where there is
   nothing, an echo is a false alarm; it may be one beside a visible object and a spot, too, that were missed. */
static inline Chain after_image(Chain chain, bool hit, double llr, double expected, Often often)
{
    const double weight = hit ? exp(smaller(MOST_EVIDENCE, llr)) : 0.0;
    const double visible = chain.visible * likelihood(often.body, expected, weight);
    return normalized(visible, chain.silent, chain.nothing, chain.spot * likelihood(often.spot, expected, weight));
}

/* Returns the probabilities given log-likelihood ratios of a body over nothing and over a spot. */
static inline Chain told_apart(Chain chain, double from_nothing, double from_spot)
{
    if (from_nothing == 0.0 && from_spot == 0.0)
        return chain;
    return normalized(chain.visible, chain.silent, chain.nothing * exp(-from_nothing), chain.spot * exp(-from_spot));
}

#endif
