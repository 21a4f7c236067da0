/* What of sensitivity.h Python calls. */

#include "ods/tracker/observer/sensitivity.h"

/* Fills mean and variance of the height's square that the variance of the height allows. */
KERNEL(possible_square, "float square, float variance, float height_variance, out f8[2] possible")
{
    double *possible = ARRAY(double, 3);
    possible[0] = possible_square_mean(FLOAT(0), FLOAT(2));
    possible[1] = possible_square_variance(FLOAT(1), FLOAT(2));
}
