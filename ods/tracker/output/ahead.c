/* Objects at later times: where each is by its velocity, and how near it comes to the vehicle (snapshot.py,
   closest_approach.py). */

#include "kernel.h"

/* n objects; vectors are (3, n), north, east, down. */
typedef struct {
    int64_t n;
    const double *position, *velocity, *sigma_position, *sigma_velocity;
    const double *is_static, *restless; /* (n,) */
    double acceleration_noise, static_noise, change_rate;
} Movers;

/* `Movers` in a signature: nine arguments. */
#define MOVERS                                                                                                          \
    "f8[3,n] position, f8[3,n] velocity, f8[3,n] sigma_position, f8[3,n] sigma_velocity, f8[n] is_static, "             \
    "f8[n] restless, float acceleration_noise, float static_noise, float change_rate"

static Movers movers_from(const Argument *arguments)
{
    return (Movers){SIZE(0, 1), ARRAY(double, 0), ARRAY(double, 1), ARRAY(double, 2), ARRAY(double, 3),
                    ARRAY(double, 4), ARRAY(double, 5), FLOAT(6), FLOAT(7), FLOAT(8)};
}

/* Returns what an acceleration of density 1 that is left off at `rate` adds to a variance in a time, s^3: the integral of
   (time - u)^2 exp(-rate u) over u from 0 to it. */
static double wandered(double rate, double time)
{
    const double left = rate * time;
    return (left * (left - 2.0) - 2.0 * expm1(-left)) / (rate * rate * rate);
}

/* Returns what manoeuvres of an object, or its creeping, add to a variance in a time, m^2. */
static double strayed(const Movers *movers, int64_t i, double time)
{
    const double usual = movers->acceleration_noise * time * time * time / 3.0;
    const double now = larger(movers->restless[i], 0.0) * wandered(movers->change_rate, time);
    return (1.0 - movers->is_static[i]) * (usual + now) + movers->is_static[i] * movers->static_noise * time;
}

/* Sets where objects are after times, s, and the standard deviations of it, m. */
KERNEL(extrapolate, MOVERS ", f8[leads,n] after_s, out f8[leads,3,n] place, out f8[leads,3,n] sigma")
{
    const Movers movers = movers_from(arguments);
    for (int64_t lead = 0; lead < SIZE(9, 0); lead++)
        for (int64_t i = 0; i < movers.n; i++) {
            const double time = ARRAY(double, 9)[lead * movers.n + i], more = strayed(&movers, i, time);
            for (int64_t axis = 0; axis < 3; axis++) {
                const int64_t k = axis * movers.n + i, at = lead * 3 * movers.n + k;
                ARRAY(double, 10)[at] = movers.position[k] + movers.velocity[k] * time;
                ARRAY(double, 11)[at] =
                    sqrt(square(movers.sigma_position[k] + movers.sigma_velocity[k] * time) + more);
            }
        }
}

/* North and east, m or m/s. */
typedef struct {
    double north, east;
} Flat;

/* Returns when an object at `offset` that moves by `drift` is nearest, in [0, horizon_s]. */
static double nearest_after(Flat offset, Flat drift, double horizon_s)
{
    const double closing = -(offset.north * drift.north + offset.east * drift.east);
    const double speed_2 = drift.north * drift.north + drift.east * drift.east;
    if (!(closing > 0.0))
        return 0.0;
    return closing < speed_2 * horizon_s ? closing / speed_2 : horizon_s;
}

/* Returns the variance of a place along the line of sight to it, of standard deviations and covariance: at distance 0 in
   any direction. */
static double along(Flat place, double distance, Flat sigma, double covariance)
{
    if (!(distance > 0.0))
        return square(larger(sigma.north, sigma.east));
    const double squared = square(place.north * sigma.north) + square(place.east * sigma.east) +
                           2.0 * place.north * place.east * covariance;
    return larger(squared / square(distance), 0.0);
}

/* Returns the mean square by which a distance changes with the velocity, of these standard deviations. */
static double by_velocity(Flat offset, Flat drift, Flat sigma, double horizon_s, double distance)
{
    static const Flat POINTS[4] = {{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}};
    const Flat apart = {sqrt(2.0) * sigma.north, sqrt(2.0) * sigma.east};
    double total = 0.0;
    for (int k = 0; k < 4; k++) {
        const Flat moved = {drift.north + POINTS[k].north * apart.north, drift.east + POINTS[k].east * apart.east};
        const double time = nearest_after(offset, moved, horizon_s);
        total += square(hypot(offset.north + moved.north * time, offset.east + moved.east * time) - distance);
    }
    return 0.25 * total;
}

/* Sets when each object is nearest to a vehicle that keeps its velocity, s, how far its middle is then, m, and the
   standard deviation of that, see `Approach`. */
KERNEL(closest_approaches, MOVERS ", f8[n] covariance_ne, f8[n] sigma_radius, f8[3] vehicle, f8[3] course, "
                                  "float horizon_s, out f8[n] time_s, out f8[n] distance_m, out f8[n] sigma_m")
{
    const Movers movers = movers_from(arguments);
    const double *vehicle = ARRAY(double, 11), *course = ARRAY(double, 12), horizon_s = FLOAT(13);
    for (int64_t i = 0; i < movers.n; i++) {
        const int64_t j = movers.n + i;
        const Flat offset = {movers.position[i] - vehicle[0], movers.position[j] - vehicle[1]};
        const Flat drift = {movers.velocity[i] - course[0], movers.velocity[j] - course[1]};
        const Flat sigma = {movers.sigma_position[i], movers.sigma_position[j]};
        const Flat faster = {movers.sigma_velocity[i], movers.sigma_velocity[j]};
        const double time = nearest_after(offset, drift, horizon_s), covariance = ARRAY(double, 9)[i];
        const Flat nearest = {offset.north + drift.north * time, offset.east + drift.east * time};
        const double distance = hypot(nearest.north, nearest.east), more = strayed(&movers, i, time);
        const Flat grown = {sqrt(square(sigma.north + faster.north * time) + more),
                            sqrt(square(sigma.east + faster.east * time) + more)};
        const double then = along(nearest, distance, grown, covariance);
        const double now = along(nearest, distance, sigma, covariance);
        const double others = now + by_velocity(offset, drift, faster, horizon_s, distance);
        ARRAY(double, 14)[i] = time;
        ARRAY(double, 15)[i] = distance;
        ARRAY(double, 16)[i] = sqrt(larger(then, others) + square(ARRAY(double, 10)[i]));
    }
}
