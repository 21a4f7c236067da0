/* How far a place's echoes wander, asked by Python (wander.h). */

#include "ods/tracker/association/wander.h"

KERNEL_FLOAT(wander_evidence, "float squares, float echoes, float of_spots_m2, float crowd, f8[5] law")
{
    return evidence_of_wander(FLOAT(0), FLOAT(1), FLOAT(2), FLOAT(3), ARRAY(const WanderLaw, 4));
}
