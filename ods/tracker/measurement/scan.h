/* What one ping gives the tracker's kernels: the vehicle and the echoes (see scan.py for what each number is). */

#ifndef ODS_SCAN_H
#define ODS_SCAN_H

#include "kernel.h"

/* The rows of the table of `Echoes`, (m,) each. */
typedef struct {
    double *range_m, *bearing, *elevation, *radius;
    double *sigma_range, *sigma_bearing, *sigma_radius, *strength;
    double *cut, *half_vertical, *onset, *front;
} EchoRows;

/* Names the rows of a (12, count) table: `f8[12,m]` in signatures. */
static inline EchoRows echo_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (EchoRows){ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6), ROW(7), ROW(8), ROW(9), ROW(10), ROW(11)};
#undef ROW
}

/* A row of a (3, 3) matrix: `rotation[i][j]`. */
typedef double MatrixRow[3];

/* The sonar's head at the ping. */
typedef struct {
    const double *position;       /* (3,) NED, m */
    const MatrixRow *rotation;    /* (3, 3) body to global */
    const double *sigma_position; /* (3,) north, east, down, m */
    const double *sigma_attitude; /* (3,) roll, pitch, yaw, rad */
    const double *noise;          /* (3,) north, east, m, and tilt, rad: what counts as new with every ping, */
    const double *bias;           /* and (3,) north, east, m, and yaw, rad: what all pings share */
} Vehicle;

/* A `Vehicle` in a signature: six arguments. */
#define VEHICLE "f8[3] position, f8[3,3] rotation, f8[3] sigma_position, f8[3] sigma_attitude, f8[3] noise, " \
                "f8[3] bias"

/* Returns the vehicle of the six arguments from number k on. */
static inline Vehicle vehicle_from(const Argument *arguments, int k)
{
    return (Vehicle){
        .position = ARRAY(const double, k),
        .rotation = ARRAY(const MatrixRow, k + 1),
        .sigma_position = ARRAY(const double, k + 2),
        .sigma_attitude = ARRAY(const double, k + 3),
        .noise = ARRAY(const double, k + 4),
        .bias = ARRAY(const double, k + 5),
    };
}

#endif
