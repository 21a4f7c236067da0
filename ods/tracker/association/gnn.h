/* One echo an object at most: which pairs have no rival (gnn.py). */

#ifndef ODS_GNN_H
#define ODS_GNN_H

#include "ods/tracker/association/hypotheses/gating.h"

/* Marks as chosen those of the pairs that are `possible`, with a score above 0, and have no rival among these; fills in
   those that have one, and returns how many these are. n objects, m echoes. */
static inline int64_t choose_undisputed(const Hypotheses *pairs, const bool *possible, int64_t n, int64_t m,
                                        bool *chosen, int64_t *disputed)
{
    int64_t *of_object = ZEROS(int64_t, n), *of_echo = ZEROS(int64_t, m), count = 0, left = 0;
    for (int64_t k = 0; k < pairs->count; k++) {
        if (!possible[k] || !(pairs->score[k] > 0.0))
            continue;
        of_object[pairs->objects[k]]++;
        of_echo[pairs->echoes[k]]++;
        disputed[count++] = k;
    }
    for (int64_t place = 0; place < count; place++) {
        const int64_t k = disputed[place];
        if (of_object[pairs->objects[k]] == 1 && of_echo[pairs->echoes[k]] == 1)
            chosen[k] = true;
        else
            disputed[left++] = k;
    }
    return left;
}

#endif
