/* Which samples hold no data (`samples_without_data` of no_data.py). */

#ifndef ODS_NO_DATA_H
#define ODS_NO_DATA_H

#include "kernel.h"

/* Samples `begin` to `stop` - 1 of a beam. */
typedef struct {
    int64_t begin, stop;
} Span;

/* (beams, samples) marks. */
typedef struct {
    const bool *marks; /* NULL: all samples hold data */
    int64_t beams, samples, stride;
} Missing;

/* What a kernel's signature says of it; `ALL_DATA` of no_data.py has no elements. */
#define MISSING "rows b1[:,:] missing"

/* argument: the one with the marks. They count if they are of beams x samples. */
static inline Missing missing_at(const Argument *argument, int64_t beams, int64_t samples)
{
    const bool fits = argument->shape[0] == beams && argument->shape[1] == samples;
    return (Missing){fits ? argument->data : NULL, beams, samples, argument->stride};
}

/* Whether a sample holds no data; there may be none at all that do not. */
static inline bool is_missing(Missing missing, int64_t beam, int64_t column)
{
    return missing.marks != NULL && missing.marks[beam * missing.stride + column];
}

/* Whether the beams on both sides of a missing cell hold data there. */
static inline bool is_one_beam_wide(Missing missing, int64_t beam, int64_t column)
{
    if (beam <= 0 || beam >= missing.beams - 1)
        return false;
    return !is_missing(missing, beam - 1, column) && !is_missing(missing, beam + 1, column);
}

/* Returns the next run of missing samples of a beam from `from` on; where there is none it begins at `samples`. */
static inline Span next_gap(const bool *gaps, int64_t from, int64_t samples)
{
    const bool *begin = from < samples ? memchr(gaps + from, true, (size_t)(samples - from)) : NULL;
    if (begin == NULL)
        return (Span){samples, samples};
    const bool *stop = memchr(begin, false, (size_t)(gaps + samples - begin));
    return (Span){begin - gaps, stop == NULL ? samples : stop - gaps};
}

#endif
