/* What of the pose's error is noise, and what is a bias that all pings share: see pose_noise.py. */

#include "ods/tracker/measurement/model.h"

/* What is compared; the last two are the vertical parts of ahead and of starboard. */
enum { NORTH, EAST, YAW, PITCHED, ROLLED, COMPARED };

/* What is known: `weight` of the pings compared, sums of squares by that weight, and the last two poses. */
typedef struct {
    double weight, squares[COMPARED], first[COMPARED], second[COMPARED];
} Known;

/* Takes in by how much a third pose, `step` of the interval before it after the second, is off where it would be. */
static void compare(Known *known, const double now[COMPARED], double step, double forgetting)
{
    const double share = 1.0 / (1.0 + square(1.0 + step) + step * step);
    for (int k = 0; k < COMPARED; k++) {
        double last = known->second[k] - known->first[k], this = now[k] - known->second[k];
        if (k == YAW)
            last = wrapped(last), this = wrapped(this);
        known->squares[k] = forgetting * known->squares[k] + share * square(this - step * last);
    }
    known->weight = forgetting * known->weight + 1.0;
}

/* Takes in the pose of a vehicle; `step`: time since the last pose, over that before it; 0: it is compared with none.
   Fills `own`, noise of north, east and tilt, then bias of north, east and yaw. */
KERNEL(pose_noise, VEHICLE ", float step, float forgetting, float least, float unsure, float prior, out f8[16] known, "
                           "out f8[2,3] own")
{
    const Vehicle vehicle = vehicle_from(arguments, 0);
    const MatrixRow *rotation = vehicle.rotation;
    const double *attitude = vehicle.sigma_attitude, claimed[] = {vehicle.sigma_position[0], vehicle.sigma_position[1], attitude[2]};
    const double now[COMPARED] = {vehicle.position[0], vehicle.position[1], atan2(rotation[1][0], rotation[0][0]),
                                  rotation[2][0], rotation[2][1]};
    Known *known = (Known *)ARRAY(double, 11);
    double *noise = ARRAY(double, 12), *bias = noise + 3;
    if (known->weight == 0.0) {
        known->weight = FLOAT(10);
        known->squares[PITCHED] = FLOAT(10) * square(attitude[1]), known->squares[ROLLED] = FLOAT(10) * square(attitude[0]);
    }
    if (FLOAT(6) > 0.0)
        compare(known, now, FLOAT(6), FLOAT(7));
    memcpy(known->first, known->second, sizeof now);
    memcpy(known->second, now, sizeof now);
    const double weight = known->weight, *squares = known->squares, most = 1.0 + FLOAT(9) / sqrt(weight);
    for (int k = 0; k < 3; k++)
        bias[k] = sqrt(larger(square(claimed[k]) - most * squares[k] / weight, 0.0));
    for (int k = 0; k < 2; k++)
        noise[k] = smaller(larger(sqrt(squares[k] / weight), FLOAT(8)), claimed[k]);
    noise[2] = sqrt(larger(squares[PITCHED], squares[ROLLED]) / weight);
}
