/* How a place's last echoes set in by the chain's judgement, asked by Python (front.h). */

#include "ods/tracker/association/front.h"

KERNEL_FLOAT(front_log_odds, "float front, f8[6] law")
{
    return log_odds_of_front(FLOAT(0), ARRAY(const FrontLaw, 1));
}

KERNEL_FLOAT(front_evidence, "float total, float echoes, float of_spots, f8[6] law")
{
    return evidence_of_front(FLOAT(0), FLOAT(1), FLOAT(2), ARRAY(const FrontLaw, 3));
}
