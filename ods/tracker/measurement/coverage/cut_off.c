/* Echoes that the fan's edge cuts off: what they add to an object that is known already.

   Of a body that reaches beyond the fan only a part is seen. Where in the body it lies nobody knows, and as the fan
   passes over the body its middle slides along it: an error that stays, or looks like a motion, and that no number of
   pings averages away. */

#include "ods/tracker/measurement/coverage/cut_off.h"
#include "ods/tracker/measurement/model.h"

/* Returns the variance of independent noise after which as much is left of `known` as of the error `shared`, `nothing`
   where none would do. */
static double beyond(double shared, double known, double nothing)
{
    return known > (1.0 + 1e-6) * shared ? known * shared / (known - shared) : nothing;
}

/* Gives k echoes that are cut off noise by which none betters what is known beyond its own error.

   `predicted`: of the objects that the echoes are of; radius, m, and its variance as they are known. What is seen of a
   body lies inside its circle: so far at most off its middle. */
KERNEL(limit_information, "out f8[12,k] table, f8[8,k] predicted, f8[k] radius, f8[k] radius_variance, "
                      "float not_measured")
{
    const int64_t count = SIZE(0, 1);
    const EchoRows echoes = echo_rows(ARRAY(double, 0), count);
    const PredictedMeasurement predicted = predicted_rows(ARRAY(double, 1), count);
    const double *radius = ARRAY(double, 2), *radius_variance = ARRAY(double, 3), nothing = FLOAT(4);
    for (int64_t j = 0; j < count; j++) {
        if (echoes.cut[j] == 0.0)
            continue;
        const double known = radius_variance[j], shared = square(echoes.sigma_radius[j]);
        const double most = farthest_off(echoes.cut[j], larger(radius[j], echoes.radius[j]), known);
        const double horizontal = predicted.horizontal[j];
        const double along = smaller(square(echoes.sigma_range[j]), most);
        const double across = smaller(square(echoes.sigma_bearing[j] * horizontal), most);
        const double noise = beyond(shared, known, nothing);
        echoes.sigma_range[j] = sqrt(beyond(along, predicted.along[j], nothing));
        echoes.sigma_bearing[j] = sqrt(beyond(across, predicted.across[j], nothing)) / horizontal;
        echoes.sigma_radius[j] = sqrt(noise);
        /* what is seen of a body is never larger than the body: it grows so far as an echo on its own would let it, but
           that does not make it surer */
        const double growth = larger(echoes.radius[j] - radius[j], 0.0);
        if (noise == nothing && growth > 0.0)
            echoes.radius[j] = radius[j] + growth * (known + noise) / (known + shared);
    }
}
