/* The next state of an object, asked by Python (lifecycle.h). */

#include "ods/tracker/existence/lifecycle.h"

KERNEL_INT(
    next_state,
    "int state, bool hit, bool inside, bool skipped, int echoes, float unseen_s, float missed_s, float existence, "
    "float visible, float first_visible, bool static, bool covered, bool duplicate, "
    "float sigma, " LIFE_LIMITS)
{
    const Evidence evidence = {BOOL(1),  BOOL(2),  BOOL(3),  INT(4),   FLOAT(5), FLOAT(6), FLOAT(7),
                               FLOAT(8), FLOAT(9), BOOL(10), BOOL(11), BOOL(12), FLOAT(13)};
    const LifeLimits limits = limits_from(arguments, 14);
    return next_state_of(INT(0), &evidence, &limits);
}
