/* The table of what became of the live objects (tracks.py). */

#ifndef ODS_TRACKS_H
#define ODS_TRACKS_H

#include "kernel.h"

/* Its rows, (n,) each: see `History` of tracks.py. */
typedef struct {
    int64_t *id, *state, *echoes, *first_utc;
    int64_t *last_utc, *born, *last, *unwatched;
} History;

/* Names the rows of an (8, count) table: `i8[8,n]` in signatures. */
static inline History history_rows(int64_t *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (History){ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6), ROW(7)};
#undef ROW
}

#endif
