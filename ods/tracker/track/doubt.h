/* The tables of what speaks for and against each live object, and of what an image shows of it (doubt.py). */

#ifndef ODS_DOUBT_H
#define ODS_DOUBT_H

#include "kernel.h"

/* The rows of the table of `Doubt`, (n,) each. */
typedef struct {
    double *visible, *silent, *nothing, *spot, *first_visible;
    double *hits, *looks;
    double *strength, *told, *by_strength;
    double *sharp, *set_in, *by_onset;
    double *fronts, *judged, *by_front;
    double *spots;
} Doubt;

/* Names the rows of a (17, count) table: `f8[17,n]` in signatures. */
static inline Doubt doubt_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (Doubt){ROW(0), ROW(1),  ROW(2),  ROW(3),  ROW(4),  ROW(5),  ROW(6),  ROW(7), ROW(8),
                   ROW(9), ROW(10), ROW(11), ROW(12), ROW(13), ROW(14), ROW(15), ROW(16)};
#undef ROW
}

/* The rows of the table of `Look`, (n,) each. */
typedef struct {
    double *llr, *watched, *expected, *strength, *onset, *front;
} Look;

/* Names the rows of a (6, count) table: `f8[6,n]` in signatures. */
static inline Look look_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (Look){ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5)};
#undef ROW
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
