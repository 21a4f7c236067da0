/* The tables of what speaks for and against each live object, and of what an image shows of it (doubt.py). */

#ifndef ODS_DOUBT_H
#define ODS_DOUBT_H

#include "kernel.h"

/* A place flickers when its chance to show an echo without an object is above this. */
#define FLICKERING 0.03

/* The rows of the table of `Doubt`, (n,) each. */
typedef struct {
    double *visible, *silent, *nothing, *spot, *first_visible;
    double *hits, *looks, *flickers;
    double *strength, *told, *by_strength, *by_motion;
    double *off_squares, *placed, *by_wander;
    double *sharp, *set_in, *by_onset;
    double *fronts, *judged, *by_front;
    double *spots;
} Doubt;

/* Names the rows of a (22, count) table: `f8[22,n]` in signatures. */
static inline Doubt doubt_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (Doubt){ROW(0),  ROW(1),  ROW(2),  ROW(3),  ROW(4),  ROW(5),  ROW(6),  ROW(7),  ROW(8),  ROW(9),  ROW(10),
                   ROW(11), ROW(12), ROW(13), ROW(14), ROW(15), ROW(16), ROW(17), ROW(18), ROW(19), ROW(20), ROW(21)};
#undef ROW
}

/* The rows of the table of `Look`, (n,) each. */
typedef struct {
    double *llr, *watched, *expected, *strength, *off_range, *onset, *front;
} Look;

/* Names the rows of a (7, count) table: `f8[7,n]` in signatures. */
static inline Look look_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (Look){ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6)};
#undef ROW
}

/* Tells whether an object is seen as places are where echoes come and go, and not as objects are there. */
static inline bool is_intermittent(const Doubt *d, int64_t i, double detection_probability)
{
    const double half_way = 0.5 * (detection_probability * d->looks[i] + d->flickers[i]);
    return d->flickers[i] > FLICKERING * d->looks[i] && d->hits[i] < half_way;
}

/* Returns the probability of existence that a new object is confirmed by; `dearer`: `onset.DEARER`. */
static inline double proof_of(const Doubt *d, int64_t i, double dearer)
{
    const double exists = d->visible[i] + d->silent[i];
    if (d->set_in[i] == 0.0)
        return exists;
    return exists / (exists + dearer * (d->nothing[i] + d->spot[i]));
}

#endif
