/* The geometry of an image of one plane of beams: `Fan.table` of fan.py. */

#ifndef ODS_FAN_H
#define ODS_FAN_H

#include "kernel.h"

/* Row b of the image is at bearing_rad[b], column j at range0_m + j * dr_m. */
typedef struct {
    int64_t beams;
    const double *bearing_rad;    /* strictly increasing, starboard positive */
    const double *borders_rad;    /* (beams + 1,) bearings that part the beams */
    const double *beam_width_rad; /* horizontal -3 dB width */
    double range0_m, dr_m, elevation_rad;
} FanTable;

/* What a kernel's signature says of it. */
#define FAN_TABLE                                                                                                      \
    "f8[beams] bearing_rad, f8[:] borders_rad, f8[beams] beam_width_rad, float range0_m, float dr_m, float elevation_rad"

/* arguments: from the fan's first one on. */
static inline FanTable fan_table_at(const Argument *arguments)
{
    return (FanTable){SIZE(0, 0), ARRAY(const double, 0), ARRAY(const double, 1), ARRAY(const double, 2),
                      FLOAT(3), FLOAT(4), FLOAT(5)};
}

#endif
