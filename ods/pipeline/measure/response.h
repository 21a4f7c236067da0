/* How wide a point is in an image: speckle through a filter is correlated as far as the filter and the pulse reach. */

#ifndef ODS_RESPONSE_H
#define ODS_RESPONSE_H

#include "ods/pipeline/measure/region.h"

/* Neighbouring cells that are compared. */
#define PAIRS 2048
/* Cells louder than this, in multiples of the background, may be an echo's. */
#define SPECKLE 1.6
/* Columns: what is taken where there is no speckle, and for what is correlated less. */
#define LEAST_POINT 1.0
/* Of speckle, in units of the square of the background: of a mean over 200 cells it is more. */
#define LEAST_VARIANCE 1e-3
/* The most that two columns' distance adds to one column's: 1 for white speckle, 4 for what is smooth. */
#define WIDEST 3.99
/* Beams and columns, and of such stretches */
#define EVERY_BEAM 6
#define STRETCH 144
/* so many have less relief than that whose speckle is taken. */
#define LEAST_SHARE 0.1

/* Returns the width, columns, that a point has at half its level along the range, in an image (beams, columns).

   A Gaussian filter of standard deviation s makes white speckle correlated by exp(-1 / 4 s^2) from column to column.
   As loud cells are left out, narrow points come out narrower, by up to a fifth. */
double width_of_point(const float *image, int64_t beams, int64_t columns, double background);

/* Returns the width, columns, that the filter and the pulse give a point; 0 where no speckle shows it.

   Of what width_of_point counts, without what the bottom's own relief adds. With q the correlation of neighbours, cells
   two columns apart differ by 1 + q + q^2 + q^3 times as much (mean squares) as neighbours do, as correlations of
   Gaussian shape are q, q^4, ...; slower changes hardly move that. Where short ripples do, in some stretches of the
   image they do not: so it is that of the stretches in which it is least. */
double width_of_response(const float *image, int64_t beams, int64_t columns, double background);

#endif
