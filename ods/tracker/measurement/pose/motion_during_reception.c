/* Echoes as a vehicle at rest would have measured them: while they come back, the vehicle moves and turns. */

#include "ods/tracker/measurement/scan.h"

typedef struct {
    double x, y, z;
} Vector;

typedef struct {
    double w, x, y, z;
} Quaternion;

/* Three poses: at transmission, halfway, and when an echo from the farthest range arrives. */
typedef struct {
    Vector place[3];
    Quaternion attitude[3];
} Poses;

/* Returns the poses of the six arguments from number k on. */
static Poses poses_from(const Argument *arguments, int k)
{
    Poses poses;
    for (int i = 0; i < 3; i++) {
        const double *p = ARRAY(double, k + i), *q = ARRAY(double, k + 3 + i);
        poses.place[i] = (Vector){p[0], p[1], p[2]};
        poses.attitude[i] = (Quaternion){q[0], q[1], q[2], q[3]};
    }
    return poses;
}

static double dot(Quaternion a, Quaternion b) { return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z; }

static Quaternion conjugate(Quaternion q) { return (Quaternion){q.w, -q.x, -q.y, -q.z}; }

/* Returns the weighted mean of three quaternions as a unit one; the first and last with the sign that is nearer to the
   middle one. */
static Quaternion blend(const Quaternion q[3], const double weight[3])
{
    const double a = copysign(weight[0], weight[0] * dot(q[0], q[1])), b = weight[1];
    const double c = copysign(weight[2], weight[2] * dot(q[2], q[1]));
    const Quaternion mean = {
        a * q[0].w + b * q[1].w + c * q[2].w,
        a * q[0].x + b * q[1].x + c * q[2].x,
        a * q[0].y + b * q[1].y + c * q[2].y,
        a * q[0].z + b * q[1].z + c * q[2].z,
    };
    const double unit = 1.0 / sqrt(dot(mean, mean));
    return (Quaternion){mean.w * unit, mean.x * unit, mean.y * unit, mean.z * unit};
}

/* Returns the body vector v in the global frame; with the conjugate of q the other way round. */
static Vector turned(Quaternion q, Vector v)
{
    const double cx = q.y * v.z - q.z * v.y + q.w * v.x;
    const double cy = q.z * v.x - q.x * v.z + q.w * v.y;
    const double cz = q.x * v.y - q.y * v.x + q.w * v.z;
    return (Vector){
        v.x + 2.0 * (q.y * cz - q.z * cy),
        v.y + 2.0 * (q.z * cx - q.x * cz),
        v.z + 2.0 * (q.x * cy - q.y * cx),
    };
}

/* Sets echo j of `seen` to what the pose at transmission would have measured. */
static void see_from_transmission(EchoRows echoes, EchoRows seen, int64_t j, const Poses *poses, double farthest)
{
    const double share = smaller(echoes.range_m[j] / farthest, 1.0);
    const double rest_share = 1.0 - share;
    const double weight[3] = {rest_share * (1.0 - 2.0 * share), 4.0 * share * rest_share, share * (2.0 * share - 1.0)};
    const double level = cos(echoes.elevation[j]), bearing = echoes.bearing[j];
    const Vector body = {level * cos(bearing), level * sin(bearing), -sin(echoes.elevation[j])};
    const Vector u = turned(blend(poses->attitude, weight), body);
    const Vector *place = poses->place;
    const double dx = weight[1] * (place[1].x - place[0].x) + weight[2] * (place[2].x - place[0].x);
    const double dy = weight[1] * (place[1].y - place[0].y) + weight[2] * (place[2].y - place[0].y);
    const double dz = weight[1] * (place[1].z - place[0].z) + weight[2] * (place[2].z - place[0].z);
    const double way = 2.0 * echoes.range_m[j], moved = dx * dx + dy * dy + dz * dz;
    if (!(moved < way * way)) /* a pose that outruns sound says nothing */
        return;
    /* the object is on the ellipse about p_tx and p_rx whose points are `way` from both together */
    const double rest = (way * way - moved) / (2.0 * (way + u.x * dx + u.y * dy + u.z * dz));
    const Vector object = {dx + rest * u.x, dy + rest * u.y, dz + rest * u.z};
    const Vector from = turned(conjugate(poses->attitude[0]), object);
    const double level_2 = square(from.x) + square(from.y);
    seen.range_m[j] = sqrt(level_2 + square(from.z));
    seen.bearing[j] = atan2(from.y, from.x);
    seen.elevation[j] = atan2(-from.z, sqrt(level_2));
}

/* Sets `seen`, a copy of `echoes`, to what the first of three poses would have measured; returns the turn from the first
   to the last, rad. */
KERNEL_FLOAT(see_at_transmission,
             "f8[12,m] echoes, f8[3] place_sent, f8[3] place_halfway, f8[3] place_end, f8[4] attitude_sent, "
             "f8[4] attitude_halfway, f8[4] attitude_end, float farthest_m, out f8[12,m] seen")
{
    const int64_t m = SIZE(0, 1);
    const EchoRows echoes = echo_rows(ARRAY(double, 0), m), seen = echo_rows(ARRAY(double, 8), m);
    const Poses poses = poses_from(arguments, 1);
    for (int64_t j = 0; j < m; j++)
        see_from_transmission(echoes, seen, j, &poses, FLOAT(7));
    const Vector forward = turned(poses.attitude[2], (Vector){1.0, 0.0, 0.0});
    const Vector ahead = turned(conjugate(poses.attitude[0]), forward);
    return atan2(ahead.y, ahead.x);
}
