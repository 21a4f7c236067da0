/* Is an object expected in this image, at the edge of the sector, or not at all? */

#include "ods/tracker/measurement/model.h"
#include "ods/tracker/measurement/coverage/normal.h"

/* An object of which more than this is hidden by blind beams may be missed. */
#define HIDDEN_SHARE 0.25
/* Keeps the distance to the edge, in standard deviations, finite. */
#define LEAST_SIGMA 1e-6

/* The sector that an image shows. */
typedef struct {
    double range_min_m, range_max_m;
    double bearing_min, bearing_max; /* rad, to starboard */
    double half_vertical;            /* rad */
    double turn;                     /* to starboard while an echo comes from a metre farther, rad/m */
} Coverage;

#define COVERAGE                                                                                                        \
    "float range_min_m, float range_max_m, float bearing_min, float bearing_max, float half_vertical, float turn"

static Coverage coverage_from(const Argument *arguments, int k)
{
    return (Coverage){FLOAT(k), FLOAT(k + 1), FLOAT(k + 2), FLOAT(k + 3), FLOAT(k + 4), FLOAT(k + 5)};
}

/* Least and largest range, or bearing, of parts of the sector: a table of rows of so many numbers. */
typedef struct {
    const double *rows;
    int64_t count;
} Parts;

/* Returns the probability that the range of an object is one of `ranges`, (k, 2); 1 when there are none. */
static double share_processed(double distance, double sigma, Parts ranges)
{
    if (ranges.count == 0)
        return 1.0;
    double total = 0.0;
    for (int64_t k = 0; k < ranges.count; k++) {
        const double *range = ranges.rows + 2 * k;
        total += normal_below((range[1] - distance) / sigma) - normal_below((range[0] - distance) / sigma);
    }
    return total;
}

/* Returns the share of an object's vertical interval that the fan covers. */
static double share_covered(double distance, double elevation, double variance, double half_vertical)
{
    const double half_fan = distance * sin(half_vertical), half_object = sqrt(3.0) * sqrt(variance) + LEAST_SIGMA;
    const double middle = distance * sin(elevation);
    const double shared = smaller(half_fan, middle + half_object) - larger(-half_fan, middle - half_object);
    return larger(shared, 0.0) / (2.0 * half_object);
}

/* Returns the share of the bearings of object i that lies in parts that the ping did not show: (k, 4) least and largest
   bearing, rad, and range, m. */
static double share_unseen(PredictedMeasurement predicted, int64_t i, double radius, double turn, Parts unseen)
{
    const double distance = predicted.range_m[i], middle = predicted.bearing[i] - turn * distance;
    const double half = larger(larger(radius, sqrt(predicted.across[i])), LEAST_SIGMA) / predicted.horizontal[i];
    double covered = 0.0;
    for (int64_t k = 0; k < unseen.count; k++) {
        const double *part = unseen.rows + 4 * k;
        if (part[2] - radius <= distance && distance <= part[3] + radius) {
            const double shared = smaller(part[1], middle + half) - larger(part[0], middle - half);
            covered += larger(shared, 0.0) / (2.0 * half);
        }
    }
    return smaller(covered, 1.0);
}

/* What the sonar sees of n objects: the fields of `FieldOfView`. */
typedef struct {
    bool *inside, *skipped, *unseen;
    double *probability, *watched;
} Seen;

/* Sets what the sonar sees of object i, were there no parts that the ping could not show. */
static void look_at(Seen seen, PredictedMeasurement predicted, int64_t i, double radius, Coverage fan, Parts processed_m,
                    double edge_sigmas)
{
    const double distance = predicted.range_m[i], horizontal = predicted.horizontal[i];
    const double sigma_range = sqrt(predicted.along[i]) + LEAST_SIGMA;
    const double sigma_bearing = sqrt(predicted.across[i]) / horizontal + LEAST_SIGMA;
    const double in_fan = predicted.bearing[i] - fan.turn * distance;
    const double to_range = smaller(distance - fan.range_min_m, fan.range_max_m - distance);
    const double to_bearing = smaller(in_fan - fan.bearing_min, fan.bearing_max - in_fan);
    const double to_edge = smaller(to_range / sigma_range, to_bearing / sigma_bearing);
    const double parts_m = PARTS * radius;
    const double to_part = smaller(to_range / length_of(sigma_range, parts_m),
                                   to_bearing / length_of(sigma_bearing, parts_m / horizontal));
    const double covered = share_covered(distance, predicted.elevation[i], predicted.vertical[i], fan.half_vertical);
    const double processed = share_processed(distance, sigma_range, processed_m);
    seen.inside[i] = to_edge >= 0.0 && covered > 0.0;
    seen.skipped[i] = seen.inside[i] && processed < 0.5;
    seen.probability[i] = normal_below(to_part) * processed;
    seen.watched[i] = to_edge >= edge_sigmas ? covered * processed : 0.0;
}

/* Predictions compared with the sector; an object is watched that is at least `edge_sigmas` inside its edges.

   An object gives an echo with the probability that one of its parts, which are normal about its middle with half its
   radius, is inside. Vertically an object is anywhere in an interval as wide as its variance allows. */
KERNEL(field_of_view,
       "f8[8,n] predicted, f8[n] radius, " COVERAGE ", f8[:,2] processed_m, f8[:,4] unseen, float edge_sigmas, "
       "float least_chance, out b1[3,n] flags, out f8[2,n] shares")
{
    const int64_t n = SIZE(0, 1);
    const PredictedMeasurement predicted = predicted_rows(ARRAY(double, 0), n);
    const double *radii = ARRAY(double, 1);
    const Coverage fan = coverage_from(arguments, 2);
    const Parts processed_m = {ARRAY(double, 8), SIZE(8, 0)}, unseen = {ARRAY(double, 9), SIZE(9, 0)};
    bool *flags = ARRAY(bool, 12);
    double *shares = ARRAY(double, 13);
    const Seen seen = {flags, flags + n, flags + 2 * n, shares, shares + n};
    for (int64_t i = 0; i < n; i++) {
        const double radius = larger(radii[i], 0.0);
        look_at(seen, predicted, i, radius, fan, processed_m, FLOAT(10));
        const double hidden = share_unseen(predicted, i, radius, fan.turn, unseen);
        seen.unseen[i] = seen.inside[i] && hidden > HIDDEN_SHARE;
        seen.skipped[i] |= seen.unseen[i];
        seen.probability[i] *= larger(1.0 - hidden, FLOAT(11));
        if (seen.unseen[i])
            seen.watched[i] = 0.0;
    }
}

/* Which predicted places are inside the sector or nearer to it than about `margin_m`. */
KERNEL(near_coverage, "f8[8,n] predicted, " COVERAGE ", float margin_m, out b1[n] near")
{
    const PredictedMeasurement predicted = predicted_rows(ARRAY(double, 0), SIZE(0, 1));
    const Coverage fan = coverage_from(arguments, 1);
    const double margin_m = FLOAT(7);
    bool *near = ARRAY(bool, 8);
    for (int64_t i = 0; i < SIZE(0, 1); i++) {
        const double turn = margin_m / predicted.horizontal[i], distance = predicted.range_m[i];
        near[i] = fan.range_min_m - margin_m <= distance && distance <= fan.range_max_m + margin_m &&
                  fan.bearing_min - turn <= predicted.bearing[i] && predicted.bearing[i] <= fan.bearing_max + turn;
    }
}

/* Which north-east places are between the fan's bearings, or not farther off than `margin_m`. */
KERNEL(in_opening, "f8[2,n] places, " VEHICLE ", " COVERAGE ", float margin_m, out b1[n] inside")
{
    const int64_t n = SIZE(0, 1);
    const double *places = ARRAY(double, 0), margin_m = FLOAT(13);
    const Vehicle vehicle = vehicle_from(arguments, 1);
    const MatrixRow *rotation = vehicle.rotation;
    const Coverage fan = coverage_from(arguments, 7);
    bool *inside = ARRAY(bool, 14);
    for (int64_t i = 0; i < n; i++) {
        const double north = places[i] - vehicle.position[0], east = places[n + i] - vehicle.position[1];
        const double ahead = rotation[0][0] * north + rotation[1][0] * east;
        const double side = rotation[0][1] * north + rotation[1][1] * east;
        const double bearing = atan2(side, ahead), margin = margin_m / larger(length_of(north, east), margin_m);
        inside[i] = bearing + margin >= fan.bearing_min && bearing - margin <= fan.bearing_max;
    }
}
