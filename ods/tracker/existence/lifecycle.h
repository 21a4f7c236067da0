/* The states of an object and what leads from one to the next (lifecycle.py has the picture). */

#ifndef ODS_LIFECYCLE_H
#define ODS_LIFECYCLE_H

#include "kernel.h"

enum { TENTATIVE, ACTIVE, STAND_BY, HIBERNATED, TERMINATED };

/* The rows of the table of `History` of tracks.py, (n,) each. */
typedef struct {
    int64_t *id, *state, *echoes, *first_utc;
    int64_t *last_utc, *born, *last, *unwatched;
} History;

/* Names the rows of an (8, count) table: `i8[8,n]` in signatures. */
static inline History history_rows(int64_t *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (History){ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6), ROW(7)};
#undef ROW
}

/* An object not proved is given up after so long without an echo, s, */
#define TENTATIVE_SILENT_S 1.0
/* or when its probability falls to this share of what it began with: two misses. */
#define TENTATIVE_DOUBT 0.03

static inline double seconds(int64_t ns)
{
    return (double)ns / 1e9;
}

/* What the newest image says of an object. */
typedef struct {
    bool hit;
    bool inside, skipped;            /* its place is in the sonar's view, but not where this image was looked at, or blind */
    int64_t echoes;                  /* so far */
    double unseen_s, missed_s;       /* since the last one, and how much of that images were looked at */
    double existence;                /* probability, */
    double visible, first_visible;   /* also that it gives echoes: now, and when it began */
    bool is_static;                  /* at a probability of at least `REST` */
    bool covered;                    /* it lies inside another object that is seen */
    bool duplicate;                  /* its echoes may be those of a confirmed object beside it */
    double sigma;                    /* standard deviation of its horizontal position, m */
} Evidence;

/* `LifeSettings`; */
typedef struct {
    int64_t confirm_echoes;
    double confirm_existence, drop_existence, edge_sigmas, silent_s, stand_by_s, lost_sigma_m;
} LifeLimits;

/* in a signature: seven arguments. */
#define LIFE_LIMITS                                                                                          \
    "int confirm_echoes, float confirm_existence, float drop_existence, float edge_sigmas, float silent_s, " \
    "float stand_by_s, float lost_sigma_m"

/* Returns the limits of the seven arguments from number k on. */
static inline LifeLimits limits_from(const Argument *arguments, int k)
{
    return (LifeLimits){INT(k), FLOAT(k + 1), FLOAT(k + 2), FLOAT(k + 3), FLOAT(k + 4), FLOAT(k + 5), FLOAT(k + 6)};
}

/* Returns the next state of a tentative object. */
static inline int64_t proved_or_not(const Evidence *e, const LifeLimits *limits)
{
    if (e->hit) {
        const bool proved = e->echoes >= limits->confirm_echoes && e->existence >= limits->confirm_existence;
        return proved && !e->duplicate ? ACTIVE : TENTATIVE;
    }
    if (e->skipped)
        return TENTATIVE;
    const bool unproved = e->visible < TENTATIVE_DOUBT * e->first_visible || e->missed_s > TENTATIVE_SILENT_S;
    return unproved ? TERMINATED : TENTATIVE;
}

/* Returns the next state of an object in stand-by or hibernated. */
static inline int64_t found_again_or_not(int64_t state, const Evidence *e, bool doubted, const LifeLimits *limits)
{
    if (e->hit)
        return ACTIVE;
    const bool overdue = (!e->inside && e->unseen_s > limits->stand_by_s) || e->sigma > limits->lost_sigma_m;
    if (doubted || (state == STAND_BY && (e->covered || (overdue && !e->is_static))))
        return TERMINATED;
    return overdue ? HIBERNATED : state;
}

/* Returns an object's state after an image. */
static inline int64_t next_state_of(int64_t state, const Evidence *e, const LifeLimits *limits)
{
    if (state == TENTATIVE)
        return proved_or_not(e, limits);
    const bool doubted = e->existence < limits->drop_existence;
    if (state == ACTIVE) {
        const bool missed = e->missed_s > limits->silent_s && !e->skipped;
        const bool lost = e->skipped && e->sigma > limits->lost_sigma_m;
        const bool unsure = !e->inside || doubted || missed || lost;
        return unsure && !e->hit ? STAND_BY : ACTIVE;
    }
    if (state == STAND_BY || state == HIBERNATED)
        return found_again_or_not(state, e, doubted, limits);
    return state;
}

/* ---------------------------------------------------------------- two tracks of one object (stitching.py) */

/* Some of n objects, by their numbers. */
typedef struct {
    const int64_t *numbers;
    int64_t count;
} Some;

/* Where n objects are: (2 or more, n) north and east, m, and (n,) radii. */
typedef struct {
    const double *north, *east, *radius;
} Circles;

/* Tells whether the middles of two objects are horizontally nearer to each other than `reach`. */
static inline bool are_near(const Circles *circles, int64_t i, int64_t j, double reach)
{
    const double north = circles->north[i] - circles->north[j], east = circles->east[i] - circles->east[j];
    return reach > 0.0 && square(north) + square(east) < square(reach);
}

/* Tells whether young object i may be stray echoes of one of the `missed`, objects not seen in this image.

   Their circles touch, and the old one was seen since the young one began, so that the young one does not continue it:
   until an image shows both, they are one. */
static inline bool is_duplicate(int64_t i, Some missed, const History *history, const Circles *circles)
{
    for (int64_t k = 0; k < missed.count; k++) {
        const int64_t j = missed.numbers[k];
        if (history->last[j] >= history->born[i] && are_near(circles, i, j, circles->radius[i] + circles->radius[j]))
            return true;
    }
    return false;
}

/* Tells whether the middle of object i lies inside the circle of one of the `others`. */
static inline bool is_covered(int64_t i, Some others, const Circles *circles)
{
    for (int64_t k = 0; k < others.count; k++)
        if (are_near(circles, i, others.numbers[k], circles->radius[others.numbers[k]]))
            return true;
    return false;
}

#endif
