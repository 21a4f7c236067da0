/* How sharply a place's echoes set in, asked by Python (onset.h). */

#include "ods/tracker/association/onset.h"

KERNEL_FLOAT(onset_evidence, "float sharp, float echoes, float of_spots, f8[7] law")
{
    return evidence_of_onset(FLOAT(0), FLOAT(1), FLOAT(2), ARRAY(const OnsetLaw, 3));
}
