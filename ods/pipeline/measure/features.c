/* The features of one echo, as Python asks for them. */

#include "ods/pipeline/measure/features.h"

KERNEL(features_of, ECHO "[1] echo, f8[6] depth, f8[8] shape, float point_m, float dr_m, out f8[15] features")
{
    Depth depth;
    Shape shape;
    memcpy(&depth, ARRAY(const double, 1), sizeof depth);
    memcpy(&shape, ARRAY(const double, 2), sizeof shape);
    find_features(ARRAY(const Echo, 0), &depth, &shape, FLOAT(3), FLOAT(4), ARRAY(double, 5));
}
