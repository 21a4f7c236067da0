/* The table of what is known of each track's existence, and of what one scan adds to it (evidence.py). */

#ifndef ODS_EVIDENCE_H
#define ODS_EVIDENCE_H

#include "kernel.h"

/* What distinguishes an object from persistent clutter: two of what its echoes look like, and its motion. */
enum { ONSET, LEADING_EDGE, MOTION, FEATURES };

/* The rows of the table of `ExistenceTable`, (n,) each. */
typedef struct {
    double *visible, *silent, *nothing, *clutter, *first_visible, *clutter_share;
    double *hits, *scans;
    /* of each feature: sum over the track's echoes, how many these are, and the log-likelihood ratio applied so far */
    struct {
        double *sum, *count, *ratio;
    } features[FEATURES];
} ExistenceTable;

/* Names the rows of a (17, count) table: `f8[17,n]` in signatures. */
static inline ExistenceTable existence_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (ExistenceTable){
        ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6), ROW(7),
        {{ROW(8), ROW(9), ROW(10)},
         {ROW(11), ROW(12), ROW(13)},
         {ROW(14), ROW(15), ROW(16)}}};
#undef ROW
}

/* The rows of the table of `ScanEvidence`, (n,) each. */
typedef struct {
    double *llr, *watched, *expected;
    double *onset, *leading_edge; /* of the track's echo; 0: none, or not measured */
} ScanEvidence;

/* Names the rows of a (5, count) table: `f8[5,n]` in signatures. */
static inline ScanEvidence evidence_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (ScanEvidence){ROW(0), ROW(1), ROW(2), ROW(3), ROW(4)};
#undef ROW
}

/* Returns the probability by which tentative track i is confirmed: where onsets are measured it needs `odds_factor`
   times the odds, as a few sharp echoes may be chance. */
static inline double confirmation_probability(const ExistenceTable *tracks, int64_t i, double odds_factor)
{
    const double exists = tracks->visible[i] + tracks->silent[i];
    if (tracks->features[ONSET].count[i] == 0.0)
        return exists;
    return exists / (exists + odds_factor * (tracks->nothing[i] + tracks->clutter[i]));
}

#endif
