/* What surrounds a sonar that moves and turns while the echoes come back, as it receives it. */

#include "ods/sim_sonar/echo/bodies/bodies.h"

/* Keeps the direction to a plane through the sonar finite. */
#define LEAST_DISTANCE_M 1e-9

/* Sets the matrix that turns body vectors into global ones, of one quaternion: geometry.rotation_matrix. */
static void set_rotation(const double *q, double (*matrix)[3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double rows[3][3] = {
        {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
        {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)},
        {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)},
    };
    memcpy(matrix, rows, sizeof rows);
}

static double distance_between(const double *a, const double *b)
{
    return sqrt(square(a[0] - b[0]) + square(a[1] - b[1]) + square(a[2] - b[2]));
}

/* Moves and turns each body, NED, about its middle: a sonar at rest in its pose at transmission, `sent`, has the same
   echoes of it as one that moves, whose pose at reception, of each body, is `received`. */
KERNEL(as_received, BODIES ", f8[bodies,3] middle, f8[3] sent_ned, f8[4] sent_attitude, f8[bodies,3] received_ned, "
                        "f8[bodies,4] received_attitude, out r152[bodies] received")
{
    const double *sent_ned = ARRAY(const double, 2);
    double forth[3][3], back[3][3];
    set_rotation(ARRAY(const double, 3), forth);
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        const Body *body = ARRAY(const Body, 0) + k;
        const double *middle = ARRAY(const double, 1) + 3 * k, *received_ned = ARRAY(const double, 4) + 3 * k;
        Body *received = ARRAY(Body, 6) + k;
        set_rotation(ARRAY(const double, 5) + 4 * k, back);
        const double again = larger(distance_between(middle, received_ned), LEAST_DISTANCE_M);
        const double stretch = 0.5 * (distance_between(middle, sent_ned) + again) / again;
        double way[3];
        for (int j = 0; j < 3; j++)
            way[j] = stretch * (middle[j] - received_ned[j]) + body->centre[j] - middle[j];
        *received = *body;
        for (int i = 0; i < 3; i++) {
            const double turn[3] = {dot(forth[i], back[0]), dot(forth[i], back[1]), dot(forth[i], back[2])};
            received->centre[i] = sent_ned[i] + dot(turn, way);
            for (int axis = 0; axis < 3; axis++)
                received->axes[axis][i] = dot(turn, body->axes[axis]);
        }
    }
}
