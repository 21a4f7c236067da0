/* Between the sonar's polar measurements and the global frame: eq. 1 with the pose at the ping, and its covariance.

   The fan has no resolution in elevation: a measurement is a range and a bearing, and a vertical interval. Where the
   object is, north and east, follows only for a given height: what is measured is a curve, given as a parabola in
   height. */

#include "ods/tracker/measurement/arctangent.h"
#include "ods/tracker/measurement/model.h"

/* Range and bearing do not give the horizontal place of an object straight above or below: no line of sight is taken to
   be steeper than that this share of the distance is horizontal. */
#define STEEPEST 0.2
/* What a place across the line of sight may add to the square of the range: at most this share of it. */
#define MOST_BENT 0.25

/* North, east, down; or their changes. */
typedef struct {
    double n, e, d;
} Ned;

static double length_of(double a, double b) { return sqrt(a * a + b * b); }

/* ---------------------------------------------------------------- what the sonar should see of objects */

/* How the sonar sees a place. */
typedef struct {
    double range_m, bearing, elevation, horizontal;
    Ned farther; /* change of the range for each metre north, east and down, */
    Ned aside;   /* and of the bearing, times the horizontal distance */
} Sight;

/* Returns how a place from the sonar is seen; a coordinate that is no number makes all that hangs on it none. */
static inline Sight sight(Ned place, const MatrixRow *rotation)
{
    const double x = place.n, y = place.e, z = place.d;
    const double ahead = rotation[0][0] * x + rotation[1][0] * y + rotation[2][0] * z;
    const double right = rotation[0][1] * x + rotation[1][1] * y + rotation[2][1] * z;
    const double below = rotation[0][2] * x + rotation[1][2] * y + rotation[2][2] * z;
    const double horizontal = larger(NEAREST_M, length_of(x, y));
    const double in_plane = larger(NEAREST_M, length_of(ahead, right));
    const double slant = larger(NEAREST_M, length_of(in_plane, below));
    const double turn = horizontal / (in_plane * in_plane);
    return (Sight){
        .range_m = slant,
        .bearing = arctangent(right, ahead),
        .elevation = arctangent(-below, in_plane),
        .horizontal = horizontal,
        .farther = {x / slant, y / slant, z / slant},
        .aside = {turn * (ahead * rotation[0][1] - right * rotation[0][0]),
                  turn * (ahead * rotation[1][1] - right * rotation[1][0]),
                  turn * (ahead * rotation[2][1] - right * rotation[2][0])},
    };
}

/* Returns a' P b for the P of north, east and down, which is not correlated with them. */
static inline double covariance(Ned a, Ned b, Ned variance, double covariance_ne)
{
    const double diagonal = a.n * b.n * variance.n + a.e * b.e * variance.e + a.d * b.d * variance.d;
    return diagonal + (a.n * b.e + a.e * b.n) * covariance_ne;
}

/* Where n objects are believed to be, under one hypothesis. */
typedef struct {
    const double *position;      /* (3, n) NED */
    const double *variance;      /* (3, n): of north and east at a given height, and of the height */
    const double *covariance_ne; /* (n,) of north and east at a given height */
    const double *by_height;     /* (2, n) by how much north and east are larger for each metre that it is lower */
    int64_t count;
} Places;

/* What the pose adds to the uncertainty of all places as the sonar sees them: the bias of the vehicle's place is theirs,
   too, but one of the attitude turns them anew as the vehicle moves. */
typedef struct {
    Ned variance;
    double tilt, yaw; /* variances, rad^2 */
} PoseError;

static PoseError pose_error(Vehicle vehicle)
{
    const double *attitude = vehicle.sigma_attitude, *noise = vehicle.noise;
    return (PoseError){
        .variance = {square(noise[0]), square(noise[1]), square(vehicle.sigma_position[2])},
        .tilt = larger(square(attitude[0]), square(attitude[1])),
        .yaw = square(attitude[2]),
    };
}

/* Sets number k of a prediction to what the sonar measures of object i: eq. 1 solved for the body frame, and the
   covariance. */
static inline void predict_one(PredictedMeasurement made, int64_t k, Places places, int64_t i, Vehicle vehicle,
                               PoseError error)
{
    const int64_t n = places.count;
    const double *position = places.position, *variance = places.variance, *by_height = places.by_height;
    const Ned place = {position[i] - vehicle.position[0], position[n + i] - vehicle.position[1],
                       position[2 * n + i] - vehicle.position[2]};
    const Sight seen = sight(place, vehicle.rotation);
    const Ned farther = seen.farther, aside = seen.aside;
    const double far_2 = square(seen.horizontal), mixed = places.covariance_ne[i], height = variance[2 * n + i];
    const Ned own = {variance[i], variance[n + i], 0.0};
    const Ned pose = {error.variance.n, error.variance.e, error.variance.d + far_2 * error.tilt};
    /* an object that is lower is also farther north and east: what of that is seen */
    const double farther_lower = farther.n * by_height[i] + farther.e * by_height[n + i] + farther.d;
    const double aside_lower = aside.n * by_height[i] + aside.e * by_height[n + i] + aside.d;
    const double own_along = covariance(farther, farther, own, mixed);
    /* what is uncertain across the line of sight makes the range longer than the distance to the middle */
    const double bent = smaller(larger(own.n + own.e - own_along, 0.0), MOST_BENT * square(seen.range_m));
    made.range_m[k] = sqrt(square(seen.range_m) + bent);
    made.bearing[k] = seen.bearing;
    made.elevation[k] = seen.elevation;
    made.horizontal[k] = seen.horizontal;
    made.along[k] = own_along + covariance(farther, farther, pose, 0.0) + square(farther_lower) * height;
    made.across[k] = covariance(aside, aside, own, mixed) + covariance(aside, aside, pose, 0.0) +
                     square(aside_lower) * height + far_2 * error.yaw;
    made.mixed[k] = covariance(farther, aside, own, mixed) + covariance(farther, aside, pose, 0.0) +
                    farther_lower * aside_lower * height;
    made.vertical[k] = height + pose.d;
}

/* Sets the predictions from number `first` on: four objects at once, as none depends on another. */
static void predict_all(PredictedMeasurement made, int64_t first, Places places, Vehicle vehicle, PoseError error)
{
    const double place[3] = {vehicle.position[0], vehicle.position[1], vehicle.position[2]};
    double rotation[3][3];
    memcpy(rotation, vehicle.rotation, sizeof rotation);
    vehicle.position = place;
    vehicle.rotation = rotation;
#pragma GCC ivdep
    for (int64_t i = 0; i < places.count; i++)
        predict_one(made, first + i, places, i, vehicle, error);
}

/* The prediction for h hypotheses of n objects. */
KERNEL(predict_hypotheses,
       "f8[h,3,n] position, f8[h,3,n] variance, f8[h,n] covariance_ne, f8[h,2,n] by_height, " VEHICLE
       ", out f8[8,h,n] made")
{
    const int64_t hypotheses = SIZE(0, 0), n = SIZE(0, 2);
    const Vehicle vehicle = vehicle_from(arguments, 4);
    const PoseError error = pose_error(vehicle);
    const PredictedMeasurement made = predicted_rows(ARRAY(double, 10), hypotheses * n);
    for (int64_t h = 0; h < hypotheses; h++) {
        const Places places = {ARRAY(double, 0) + 3 * h * n, ARRAY(double, 1) + 3 * h * n, ARRAY(double, 2) + h * n,
                               ARRAY(double, 3) + 2 * h * n, n};
        predict_all(made, h * n, places, vehicle, error);
    }
}

/* The prediction for n objects. */
KERNEL(predict_objects,
       "f8[3,n] position, f8[3,n] variance, f8[n] covariance_ne, f8[2,n] by_height, " VEHICLE ", out f8[8,n] made")
{
    const int64_t n = SIZE(0, 1);
    const Places places = {ARRAY(double, 0), ARRAY(double, 1), ARRAY(double, 2), ARRAY(double, 3), n};
    const Vehicle vehicle = vehicle_from(arguments, 4);
    const PoseError error = pose_error(vehicle);
    predict_all(predicted_rows(ARRAY(double, 10), n), 0, places, vehicle, error);
}

/* ---------------------------------------------------------------- echoes to places */

/* Sine and cosine of an angle. */
typedef struct {
    double sine, cosine;
} Turned;

/* Where an object seen at a range and bearing can be, and how that changes: north and east. */
typedef struct {
    double per_range[2];   /* change per metre of range, */
    double per_bearing[2]; /* per rad of bearing, */
    double by_height[2];   /* per metre that the object is lower, */
    double bend[2];        /* and per m^2 of that */
} Curve;

/* Returns how the horizontal place changes at `place` from the sonar.

   |place| is the range, and place . n = 0, n the normal of the half-plane of the bearing. Both hold at every height;
   that the first is a square bends the curve. */
static Curve curve_at(Ned place, Turned bearing, const MatrixRow *rotation)
{
    const double x = place.n, y = place.e, z = place.d, sine = bearing.sine, cosine = bearing.cosine;
    const double n_n = cosine * rotation[0][1] - sine * rotation[0][0];
    const double n_e = cosine * rotation[1][1] - sine * rotation[1][0];
    const double n_d = cosine * rotation[2][1] - sine * rotation[2][0];
    const double in_plane = (cosine * rotation[0][0] + sine * rotation[0][1]) * x +
                            (cosine * rotation[1][0] + sine * rotation[1][1]) * y +
                            (cosine * rotation[2][0] + sine * rotation[2][1]) * z;
    const double slant = larger(NEAREST_M, sqrt(x * x + y * y + z * z));
    const double cross = x * n_e - y * n_n;
    const double determinant = copysign(larger(fabs(cross), STEEPEST * slant), cross);
    const double away[2] = {n_e / determinant, -n_n / determinant};
    const double aside[2] = {-y / determinant, x / determinant};
    const double by_height[2] = {-away[0] * z - aside[0] * n_d, -away[1] * z - aside[1] * n_d};
    const double bent = -0.5 * (1.0 + square(by_height[0]) + square(by_height[1]));
    return (Curve){
        {slant * away[0], slant * away[1]},
        {in_plane * aside[0], in_plane * aside[1]},
        {by_height[0], by_height[1]},
        {bent * away[0], bent * away[1]},
    };
}

/* Where range and bearing of an echo are taken in. */
typedef struct {
    double range_m, bearing, elevation;
    double across; /* variance of the object's place across the line of sight, m^2 */
} Aim;

/* Returns where echo j is taken in: where it is, if it is of a new object, else where the object should be. */
static Aim aim_of(EchoRows echoes, PredictedMeasurement predicted, int64_t j, bool is_new, double half, double yaw)
{
    const double distance = echoes.range_m[j], level = echoes.elevation[j];
    if (is_new) {
        const double across = square(distance * cos(level)) * (square(echoes.sigma_bearing[j]) + square(yaw));
        return (Aim){distance, echoes.bearing[j], level, across};
    }
    const double elevation = smaller(larger(predicted.elevation[j], level - half), level + half);
    return (Aim){predicted.range_m[j], predicted.bearing[j], elevation, predicted.across[j]};
}

/* Returns a place relative to the sonar. */
static Ned from_sonar(double distance, Turned bearing, double elevation, const MatrixRow *rotation)
{
    const double in_plane = distance * cos(elevation), below = -distance * sin(elevation);
    const double ahead = in_plane * bearing.cosine, right = in_plane * bearing.sine;
    return (Ned){
        rotation[0][0] * ahead + rotation[0][1] * right + rotation[0][2] * below,
        rotation[1][0] * ahead + rotation[1][1] * right + rotation[1][2] * below,
        rotation[2][0] * ahead + rotation[2][1] * right + rotation[2][2] * below,
    };
}

/* What is measured of m echoes: the fields of `PositionMeasurement`. */
typedef struct {
    double *position;                                                    /* (3, m) */
    double *variance_north, *variance_east, *covariance_ne, *half_height; /* (m,) each, as are the next three */
    double *radius, *radius_variance, *height;
    double *azimuth;     /* (2, m) */
    double *sensitivity; /* (UNSEEN, 2, m) */
    int64_t count;
} Measured;

/* Sets what the ping does not see, but the horizontal place of echo j depends on. */
static void set_sensitivity(Measured made, int64_t j, Curve curve, Ned place, double biased)
{
    double(*axes)[2] = (double[UNSEEN][2]){
        [HEIGHT] = {curve.by_height[0], curve.by_height[1]},
        [BEND] = {curve.bend[0], curve.bend[1]},
        [ATTITUDE] = {-biased * place.e, biased * place.n},
        [CLIMB] = {0.0, 0.0},
    };
    for (int what = 0; what < UNSEEN; what++)
        for (int axis = 0; axis < 2; axis++)
            made.sensitivity[(2 * what + axis) * made.count + j] = axes[what][axis];
}

/* Sets place and covariance of echo j, which is taken in at `place` from the sonar; `longer`: what the range is longer
   than the distance to the middle of where the object is. */
static void set_place(Measured made, EchoRows echoes, int64_t j, Aim aim, Ned place, Curve curve, double longer,
                      Vehicle vehicle)
{
    const double *own = vehicle.noise, *along = curve.per_range, *across = curve.per_bearing;
    const double yaw_2 = square(vehicle.sigma_attitude[2]);
    const double farther = echoes.range_m[j] - aim.range_m - longer, aside = wrapped(echoes.bearing[j] - aim.bearing);
    const double s_range = square(echoes.sigma_range[j]) + 2.0 * square(longer);
    const double s_bearing = square(echoes.sigma_bearing[j]) + yaw_2;
    made.position[j] = vehicle.position[0] + place.n + along[0] * farther + across[0] * aside;
    made.position[made.count + j] = vehicle.position[1] + place.e + along[1] * farther + across[1] * aside;
    made.variance_north[j] = square(along[0]) * s_range + square(across[0]) * s_bearing + square(own[0]);
    made.variance_east[j] = square(along[1]) * s_range + square(across[1]) * s_bearing + square(own[1]);
    made.covariance_ne[j] = along[0] * along[1] * s_range + across[0] * across[1] * s_bearing;
}

/* Sets all of echo j; `half_vertical`: half the fan's vertical opening, rad, for echoes that have none of their own. */
static void measure_one(Measured made, EchoRows echoes, PredictedMeasurement predicted, int64_t j, bool is_new,
                        Vehicle vehicle, double half_vertical)
{
    const MatrixRow *rotation = vehicle.rotation;
    const double yaw = vehicle.sigma_attitude[2];
    const double tilt = larger(vehicle.sigma_attitude[0], vehicle.sigma_attitude[1]);
    const double half = echoes.half_vertical[j] > 0.0 ? echoes.half_vertical[j] : half_vertical;
    const Aim aim = aim_of(echoes, predicted, j, is_new, half, yaw);
    const Turned turned = {sin(aim.bearing), cos(aim.bearing)};
    const Ned place = from_sonar(aim.range_m, turned, aim.elevation, rotation);
    const Curve curve = curve_at(place, turned, rotation);
    const double longer = 0.5 * smaller(aim.across, MOST_BENT * square(aim.range_m)) / aim.range_m;
    set_place(made, echoes, j, aim, place, curve, longer, vehicle);
    /* the height measured is that of the fan's middle, wherever in the fan the object is */
    const Ned middle = from_sonar(aim.range_m, turned, echoes.elevation[j], rotation);
    made.position[2 * made.count + j] = vehicle.position[2] + middle.d;
    const double away_2 = square(place.n) + square(place.e), half_fan = aim.range_m * (sin(half) * fabs(rotation[2][2]));
    made.half_height[j] = half_fan + vehicle.sigma_position[2] + sqrt(away_2) * tilt;
    made.radius[j] = echoes.radius[j];
    made.radius_variance[j] = square(echoes.sigma_radius[j]);
    made.height[j] = vehicle.position[2] + place.d;
    const double horizontal_2 = larger(away_2, square(STEEPEST * aim.range_m));
    made.azimuth[j] = -place.e / horizontal_2;
    made.azimuth[made.count + j] = place.n / horizontal_2;
    const double height_variance = is_new ? square(half_fan) / 3.0 : predicted.vertical[j];
    /* a tilt turns what is higher or lower than the sonar aside, as a yaw does all */
    const double biased = sqrt(square(vehicle.bias[2]) + square(tilt) * (square(place.d) + height_variance) / horizontal_2);
    set_sensitivity(made, j, curve, place, biased);
}

/* Eq. 1, z_og = z_ag + R^-1 z_ob, for all echoes, with measurement noise that includes the pose's.

   `predicted`: one prediction for each echo, of the object that it is of; none: the echoes are of new objects. Range and
   bearing of a known object are taken in where it should be, along the tangent there: across wide beams the noise would
   bend the ellipse, and turn it anew with each echo. A new object is where its echo is, in the fan's middle. `rest`: the
   fields of `PositionMeasurement` from variance_north to height. */
KERNEL(measure_positions,
       "f8[12,m] echoes, f8[8,:] predicted, " VEHICLE ", float half_vertical, "
       "out f8[3,m] position, out f8[7,m] rest, out f8[2,m] azimuth, out f8[4,2,m] sensitivity")
{
    const int64_t m = SIZE(0, 1);
    const bool is_new = SIZE(1, 1) != m;
    const EchoRows echoes = echo_rows(ARRAY(double, 0), m);
    const PredictedMeasurement predicted = predicted_rows(ARRAY(double, 1), SIZE(1, 1));
    const Vehicle vehicle = vehicle_from(arguments, 2);
    double *rest = ARRAY(double, 10);
    const Measured made = {
        .position = ARRAY(double, 9),
        .variance_north = rest,
        .variance_east = rest + m,
        .covariance_ne = rest + 2 * m,
        .half_height = rest + 3 * m,
        .radius = rest + 4 * m,
        .radius_variance = rest + 5 * m,
        .height = rest + 6 * m,
        .azimuth = ARRAY(double, 11),
        .sensitivity = ARRAY(double, 12),
        .count = m,
    };
    for (int64_t j = 0; j < m; j++)
        measure_one(made, echoes, predicted, j, is_new, vehicle, FLOAT(8));
}
