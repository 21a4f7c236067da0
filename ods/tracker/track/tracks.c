/* Changes to the table of what became of the live objects (tracks.py). */

#include "ods/tracker/existence/lifecycle.h"
#include "ods/tracker/track/tracks.h"

/* Takes note that the objects `rows` were seen. */
KERNEL(tracks_seen, "out i8[8,n] history, i8[k] rows, int t_ns, int utc_ns")
{
    const int64_t n = SIZE(0, 1), *rows = ARRAY(const int64_t, 1);
    const History history = history_rows(ARRAY(int64_t, 0), n);
    for (int64_t k = 0; k < SIZE(1, 0); k++) {
        const int64_t i = rows[k];
        if (i < 0 || i >= n)
            continue;
        history.echoes[i]++;
        history.last[i] = INT(2);
        history.last_utc[i] = INT(3);
        history.unwatched[i] = 0;
    }
}

/* Sets tentative objects from `first` on, seen once. */
KERNEL(tracks_begin, "out i8[8,n] history, int first, int t_ns, int utc_ns")
{
    const int64_t n = SIZE(0, 1);
    const History history = history_rows(ARRAY(int64_t, 0), n);
    for (int64_t i = larger_i(INT(1), 0); i < n; i++) {
        history.state[i] = TENTATIVE;
        history.echoes[i] = 1;
        history.born[i] = history.last[i] = INT(2);
        history.first_utc[i] = history.last_utc[i] = INT(3);
    }
}
