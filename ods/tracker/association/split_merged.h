/* Where echoes and objects are not one to one: several echoes of a large object, one echo of two close objects. */

#ifndef ODS_SPLIT_MERGED_H
#define ODS_SPLIT_MERGED_H

#include "ods/tracker/association/hypotheses/gating.h"
#include "ods/tracker/measurement/model.h"


/* n objects, as they are predicted. */
typedef struct {
    PredictedMeasurement predicted;
    const double *radius;  /* (n,) */
    const bool *confirmed; /* (n,) */
    int64_t n;
} Bodies;

/* The confirmed ones of them, by their numbers. */
typedef struct {
    int64_t *numbers, count;
} Confirmed;

static inline Confirmed confirmed_of(const Bodies *bodies)
{
    Confirmed confirmed = {SCRATCH(int64_t, bodies->n), 0};
    for (int64_t i = 0; i < bodies->n; i++)
        if (bodies->confirmed[i])
            confirmed.numbers[confirmed.count++] = i;
    return confirmed;
}

/* Some echoes of an image and the objects that they are parts of, and the log-likelihood ratio that they are. */
typedef struct {
    int64_t *objects, *echoes;
    double *llr;
    int64_t count;
} Parts;

static inline Parts room_for_parts(int64_t most)
{
    return (Parts){SCRATCH(int64_t, most), SCRATCH(int64_t, most), SCRATCH(double, most), 0};
}

static inline void add_part(Parts *parts, int64_t object, int64_t echo, double llr)
{
    parts->objects[parts->count] = object;
    parts->echoes[parts->count] = echo;
    parts->llr[parts->count++] = llr;
}

/* Returns the confirmed object whose circle echo j is deepest inside of; -1: none. */
static inline int64_t whole_of(const EchoRows *echoes, int64_t j, const Bodies *bodies, const Confirmed *confirmed)
{
    const PredictedMeasurement *predicted = &bodies->predicted;
    double deepest = 0.0;
    int64_t whole = -1;
    for (int64_t k = 0; k < confirmed->count; k++) {
        const int64_t i = confirmed->numbers[k];
        const double along = echoes->range_m[j] - predicted->range_m[i];
        if (!(fabs(along) < bodies->radius[i]))
            continue;
        const double across = wrapped(echoes->bearing[j] - predicted->bearing[i]) * predicted->horizontal[i];
        const double excess = sqrt(square(along) + square(across)) - bodies->radius[i];
        if (excess < deepest)
            deepest = excess, whole = i;
    }
    return whole;
}

/* What one echo stands for that is of several: (most,) objects, each once, the best log-likelihood ratio of each, and
   the first of its echoes; its range and bearing are the means of all. */
typedef struct {
    int64_t *objects, *first;
    double *llr, *range_m, *bearing, *echoes;
    int64_t count;
} Together;

/* Puts the parts of each of n objects together. */
static inline Together put_together(const Parts *parts, const EchoRows *echoes, int64_t n)
{
    const int64_t most = parts->count;
    Together made = {SCRATCH(int64_t, most),
                     SCRATCH(int64_t, most),
                     SCRATCH(double, most),
                     ZEROS(double, most),
                     ZEROS(double, most),
                     ZEROS(double, most),
                     0};
    int64_t *place = SCRATCH(int64_t, n);
    memset(place, -1, (size_t)n * sizeof *place);
    for (int64_t part = 0; part < parts->count; part++) {
        const int64_t i = parts->objects[part], j = parts->echoes[part];
        if (place[i] < 0) {
            place[i] = made.count++;
            made.objects[place[i]] = i, made.first[place[i]] = j, made.llr[place[i]] = parts->llr[part];
        }
        const int64_t k = place[i];
        made.llr[k] = larger(parts->llr[part], made.llr[k]);
        made.range_m[k] += echoes->range_m[j];
        made.bearing[k] += echoes->bearing[j];
        made.echoes[k] += 1.0;
    }
    for (int64_t k = 0; k < made.count; k++) {
        made.range_m[k] /= made.echoes[k];
        made.bearing[k] /= made.echoes[k];
    }
    return made;
}

/* Fills in the variance, m^2, (n,), by which an echo may lie off its object's centre because it is of two objects.

   Where the circles of two objects touch and only one of them is `hit`, its echo may be the echo of both; both are
   confirmed, and the sonar looks at them with a probability `watched`. 0: no such neighbour. position: (3, n). */
static inline void find_merged(const Bodies *bodies, const double *position, const bool *hit, const double *watched,
                               double *variance)
{
    const double *north = position, *east = north + bodies->n, *radius = bodies->radius;
    int64_t *unseen = SCRATCH(int64_t, bodies->n), count = 0;
    for (int64_t i = 0; i < bodies->n; i++) {
        variance[i] = 0.0;
        if (bodies->confirmed[i] && watched[i] > 0.0 && !hit[i])
            unseen[count++] = i;
    }
    for (int64_t i = 0; i < bodies->n; i++) {
        if (!(bodies->confirmed[i] && watched[i] > 0.0 && hit[i]))
            continue;
        for (int64_t k = 0; k < count; k++) {
            const int64_t j = unseen[k];
            const double apart_2 = square(north[i] - north[j]) + square(east[i] - east[j]),
                         reach = radius[i] + radius[j];
            if (!(reach > 0.0 && apart_2 < square(reach)))
                continue;
            const double half = square(larger(0.5 * sqrt(apart_2), NEAREST_M));
            variance[i] = larger(half, variance[i]);
            variance[j] = larger(half, variance[j]);
        }
    }
}

#endif
