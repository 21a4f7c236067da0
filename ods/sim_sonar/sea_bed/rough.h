/* A rough sea-bed as the sonar sees it, along the half plane of one bearing: a trace. */

#ifndef ODS_ROUGH_H
#define ODS_ROUGH_H

#include "kernel.h"

/* One over the cosine of the lean, about one degree, above which a trace is surveyed twice. */
#define LEANING 1.0002

/* A row of a (3, 3) matrix. */
typedef double TurnRow[3];

/* See rough.py; its frame is the mean plane's: x, y in the plane, z down. */
typedef struct {
    const float *nodes;      /* (rows + 1, columns + 1, 3) height, up positive, and slopes in x and y */
    int64_t rows, columns;   /* facets of the field in x and in y */
    double facet_m, corner_x, corner_y;
    bool repeats;
    const double *sonar_m;   /* (3,) */
    const TurnRow *turn;     /* (3, 3) from the sonar's frame to the sea-bed's */
    double turning;
    const double *gamma; /* (gamma_nodes,) eq. 3 over cos(alpha), even from 0 to 1 */
    int64_t gamma_nodes;
} RoughBed;

/* A `RoughBed` in a signature: nine arguments. */
#define ROUGH_BED                                                                                                       \
    "f4[:,:,3] nodes, float facet_m, float corner_x, float corner_y, bool repeats, f8[3] sonar_m, f8[3,3] turn, "       \
    "float turning, f8[:] gamma"

/* Returns the bed of the nine arguments from number k on. */
static inline RoughBed rough_bed_from(const Argument *arguments, int k)
{
    return (RoughBed){
        .nodes = ARRAY(const float, k),
        .rows = SIZE(k, 0) - 1,
        .columns = SIZE(k, 1) - 1,
        .facet_m = FLOAT(k + 1),
        .corner_x = FLOAT(k + 2),
        .corner_y = FLOAT(k + 3),
        .repeats = BOOL(k + 4),
        .sonar_m = ARRAY(const double, k + 5),
        .turn = ARRAY(const TurnRow, k + 6),
        .turning = FLOAT(k + 7),
        .gamma = ARRAY(const double, k + 8),
        .gamma_nodes = SIZE(k + 8, 0),
    };
}

/* Two coordinates in the sea-bed's plane. */
typedef struct {
    double x, y;
} Level;

/* The half plane of one bearing, in the sea-bed's frame; places in facets from the field's corner. */
typedef struct {
    Level start;        /* below the sonar */
    Level ahead;        /* change of place per metre ahead */
    Level upward;       /* change of place per metre up the sonar's axis */
    Level toward;       /* direction ahead, metres in x and y per metre */
    double across[3];   /* unit normal */
    double height;      /* of the sonar above the mean plane, m */
    double down;        /* fall per metre ahead */
    Level per_side;     /* one over the field's facets in x and in y */
    double stretch;     /* metres up the sonar's axis per metre of height */
} Trace;

/* Returns the half plane of a bearing. */
static inline Trace trace_of(const RoughBed *bed, double bearing_rad)
{
    const double c = cos(bearing_rad), s = sin(bearing_rad), unit = 1.0 / bed->facet_m;
    const TurnRow *m = bed->turn;
    const Level toward = {m[0][0] * c + m[0][1] * s, m[1][0] * c + m[1][1] * s};
    return (Trace){
        .start = {(bed->sonar_m[0] - bed->corner_x) * unit, (bed->sonar_m[1] - bed->corner_y) * unit},
        .ahead = {toward.x * unit, toward.y * unit},
        .upward = {-m[0][2] * unit, -m[1][2] * unit},
        .toward = toward,
        .across = {m[0][1] * c - m[0][0] * s, m[1][1] * c - m[1][0] * s, m[2][1] * c - m[2][0] * s},
        .height = -bed->sonar_m[2],
        .down = m[2][0] * c + m[2][1] * s,
        .per_side = {1.0 / (double)bed->rows, 1.0 / (double)bed->columns},
        .stretch = 1.0 / m[2][2],
    };
}

/* The sea-bed at the steps of a trace. */
typedef struct {
    const double *ahead; /* (steps,) m */
    int64_t steps;
    double *up;          /* metres up the sonar's axis */
    double *slope_x, *slope_y;
    double *place_x, *place_y; /* in facets, to work in */
} Land;

static inline Land land_of(const double *ahead, int64_t steps)
{
    return (Land){ahead, steps, SCRATCH(double, steps), SCRATCH(double, steps), SCRATCH(double, steps),
                  SCRATCH(double, steps), SCRATCH(double, steps)};
}

/* Returns the cosine of what a sonar turns meanwhile: at 60 deg/s and 100 m it is right to 2e-4 of the range. */
static inline double cosine_of(double turned)
{
    return 1.0 - 0.5 * turned * turned;
}

/* Sets the places under the sonar's line of sight. A sonar that turns while it listens looks at each place along the
   bearing that it has at reception; the sea-bed is turned back by that about the sonar, slopes and all, so that the
   trace is straight. */
static inline void find_places(const RoughBed *bed, const Trace *trace, Land land)
{
    const double *restrict ahead = land.ahead, *restrict up = land.up;
    double *restrict place_x = land.place_x, *restrict place_y = land.place_y;
    for (int64_t k = 0; k < land.steps; k++) {
        const double aside = bed->turning * ahead[k], onward = cosine_of(aside);
        const double x = ahead[k] * trace->ahead.x + up[k] * trace->upward.x;
        const double y = ahead[k] * trace->ahead.y + up[k] * trace->upward.y;
        place_x[k] = trace->start.x + onward * x - aside * y;
        place_y[k] = trace->start.y + onward * y + aside * x;
    }
    if (!bed->repeats)
        return;
    const double south = (double)bed->rows, east = (double)bed->columns;
    for (int64_t k = 0; k < land.steps; k++) {
        place_x[k] -= south * floor(place_x[k] * trace->per_side.x);
        place_y[k] -= east * floor(place_y[k] * trace->per_side.y);
    }
}

/* Returns one of the three numbers of the nodes at a place of a facet, whose first node it is. */
static inline float between(const float *facet, int64_t line, float a, float b)
{
    const float first = facet[0] + a * (facet[line] - facet[0]);
    const float second = facet[3] + a * (facet[line + 3] - facet[3]);
    return first + b * (second - first);
}

/* Sets the land at its places; beyond the field's border it is even. */
static inline void look(const RoughBed *bed, const Trace *trace, Land land)
{
    const int64_t line = 3 * (bed->columns + 1);
    const double south = (double)bed->rows, east = (double)bed->columns;
    const double *restrict ahead = land.ahead;
    find_places(bed, trace, land);
    for (int64_t k = 0; k < land.steps; k++) {
        const double x = land.place_x[k], y = land.place_y[k];
        const double aside = bed->turning * ahead[k], onward = cosine_of(aside);
        const double p = smaller(larger(x, 0.0), south), q = smaller(larger(y, 0.0), east);
        const int32_t i = (int32_t)smaller(p, south - 1.0), j = (int32_t)smaller(q, east - 1.0);
        const float *facet = bed->nodes + i * line + 3 * (int64_t)j;
        const float a = (float)(p - i), b = (float)(q - j);
        const double rise_x = 0.0 <= x && x <= south ? between(facet + 1, line, a, b) : 0.0;
        const double rise_y = 0.0 <= y && y <= east ? between(facet + 2, line, a, b) : 0.0;
        land.slope_x[k] = onward * rise_x + aside * rise_y;
        land.slope_y[k] = onward * rise_y - aside * rise_x;
        land.up[k] = (ahead[k] * trace->down - trace->height + between(facet, line, a, b)) * trace->stretch;
    }
}

/* Sets `land` to the sea-bed along a trace. When the vehicle leans, where a point of the sea-bed lies depends on its
   height: a second look corrects the first. */
static inline void survey(const RoughBed *bed, const Trace *trace, Land land)
{
    for (int64_t k = 0; k < land.steps; k++)
        land.up[k] = (land.ahead[k] * trace->down - trace->height) * trace->stretch;
    look(bed, trace, land);
    if (trace->stretch > LEANING)
        look(bed, trace, land);
}

/* How fine the steps and columns are: see `Detail` of detail.py. */
typedef struct {
    double max_error, step, turn, growth, spacing, lean, reach;
} Detail;

/* A `Detail` in a signature: seven arguments. */
#define DETAIL                                                                                                          \
    "float max_error, float step, float turn_rad, float growth, float spacing, float lean, float reach"

/* Returns the detail of the seven arguments from number k on. */
static inline Detail detail_from(const Argument *arguments, int k)
{
    return (Detail){FLOAT(k), FLOAT(k + 1), FLOAT(k + 2), FLOAT(k + 3), FLOAT(k + 4), FLOAT(k + 5), FLOAT(k + 6)};
}

/* Sets `ends`, unless it is NULL, to the ends of the steps from straight below to `farthest_m` ahead, for a sonar
   `height_m` above the bed; returns how many. */
static inline int64_t steps_ahead(double height_m, double scale_m, double farthest_m, const Detail *detail, double *ends)
{
    int64_t count = 0;
    double here = 0.0, next = 0.0;
    do {
        here = next;
        if (ends != NULL)
            ends[count] = here;
        count++;
        const double angular = detail->turn * (height_m * height_m + here * here) / height_m;
        next = here + smaller(smaller(detail->step * scale_m, angular), detail->growth * (here + height_m));
    } while (here < farthest_m && next > here);
    return count;
}

#endif
