/* Whether changes of state ask for more than to take note of them (management.py). */

#include "ods/tracker/existence/lifecycle.h"

/* Tells whether any object is lost out of view, is confirmed, and ends or rests once confirmed. */
KERNEL(management_events, "i8[n] before, i8[n] states, b1[n] inside, out b1[3] events")
{
    const int64_t *before = ARRAY(const int64_t, 0), *states = ARRAY(const int64_t, 1);
    const bool *inside = ARRAY(const bool, 2);
    bool lost = false, confirmed = false, for_the_map = false;
    for (int64_t i = 0; i < SIZE(0, 0); i++) {
        lost |= states[i] == STAND_BY && !inside[i];
        confirmed |= before[i] == TENTATIVE && states[i] == ACTIVE;
        for_the_map |= states[i] == HIBERNATED || (states[i] == TERMINATED && before[i] != TENTATIVE);
    }
    bool *events = ARRAY(bool, 3);
    events[0] = lost, events[1] = confirmed, events[2] = for_the_map;
}
