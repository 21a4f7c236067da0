/* Pairs of an object and an echo that may be its own (gating.py). */

#ifndef ODS_GATING_H
#define ODS_GATING_H

#include "kernel.h"

/* Largest log-likelihood ratio of an echo: e^25 leaves no doubt, and no rival's share is lost to rounding. */
#define MOST_RATIO 25.0

/* `Hypotheses`, (count,) each; */
typedef struct {
    const int64_t *objects, *echoes;
    const double *llr, *score;
    int64_t count;
} Hypotheses;

/* in a signature: four arguments. */
#define HYPOTHESES "i8[p] objects, i8[p] echoes, f8[p] llr, f8[p] score"

/* Returns the pairs of the four arguments from number k on. */
static inline Hypotheses hypotheses_from(const Argument *arguments, int k)
{
    return (Hypotheses){ARRAY(const int64_t, k), ARRAY(const int64_t, k + 1), ARRAY(const double, k + 2),
                        ARRAY(const double, k + 3), SIZE(k, 0)};
}

/* Tells whether pair k is of one of n objects and one of m echoes: associations of users' own make pairs, too. */
static inline bool is_pair(const Hypotheses *pairs, int64_t k, int64_t n, int64_t m)
{
    return pairs->objects[k] >= 0 && pairs->objects[k] < n && pairs->echoes[k] >= 0 && pairs->echoes[k] < m;
}

/* Returns by how much the log-likelihood ratio of a pair, or a missed object and a false alarm, is above that of the
   echo being of this object, or a false alarm. `visibility`: that the object is in view and gives echoes at all just
   now. */
static inline double score_over_llr(double visibility, double detection_probability)
{
    const double visible = larger(NOT_ZERO, visibility);
    return log(visible) - log1p(-detection_probability * visible);
}

#endif
