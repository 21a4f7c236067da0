/* The generic objects of [SSIE] (see bodies.py), and where a ray from the sonar meets them. */

#ifndef ODS_BODIES_H
#define ODS_BODIES_H

#include "kernel.h"

/* Range of a ray that meets nothing, m. */
#define FAR 1e12
/* Of a ray's direction: along an axis of a body. */
#define PARALLEL 1e-12

enum { SPHERE, CYLINDER, PLANE };

/* bodies.BODY */
typedef struct {
    int64_t kind;
    double centre[3];
    double axes[3][3]; /* local axes, the rows of a rotation matrix */
    double half[3];
    double cd, cs, sigma_rad;
} Body;

/* Bodies in a signature: one argument. */
#define BODIES "r152[bodies] bodies"
_Static_assert(sizeof(Body) == 152, "as in BODIES");

typedef struct {
    double range_m, cosine; /* the latter of the incidence angle */
} Hit;

#define NO_HIT ((Hit){FAR, 0.0})

/* A ray in a body's own axes: where the sonar is, m from the body's centre, and a unit vector along the ray. */
typedef struct {
    double ox, oy, oz, dx, dy, dz;
} LocalRay;

static inline double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline LocalRay local_ray(const Body *body, double x, double y, double z)
{
    const double along[3] = {x, y, z};
    return (LocalRay){
        -dot(body->axes[0], body->centre), -dot(body->axes[1], body->centre), -dot(body->axes[2], body->centre),
        dot(body->axes[0], along), dot(body->axes[1], along), dot(body->axes[2], along),
    };
}

static inline Hit hit_sphere(const Body *body, double x, double y, double z)
{
    const double *centre = body->centre, radius = body->half[0];
    const double along = centre[0] * x + centre[1] * y + centre[2] * z;
    const double inside = radius * radius - (dot(centre, centre) - along * along);
    if (inside <= 0.0 || along <= 0.0)
        return NO_HIT;
    const double root = sqrt(inside), distance = along - root;
    return distance > 0.0 ? (Hit){distance, root / radius} : NO_HIT;
}

static inline Hit hit_cylinder(double radius, double half, LocalRay ray)
{
    const double a = square(ray.dx) + square(ray.dy), b = ray.ox * ray.dx + ray.oy * ray.dy;
    const double inside = b * b - a * (square(ray.ox) + square(ray.oy) - radius * radius);
    if (a > PARALLEL && inside > 0.0) {
        const double root = sqrt(inside), distance = (-b - root) / a;
        if (distance > 0.0 && fabs(ray.oz + distance * ray.dz) <= half)
            return (Hit){distance, root / radius};
    }
    if (fabs(ray.dz) > PARALLEL && fabs(ray.oz) > half) {
        const double distance = (copysign(half, ray.oz) - ray.oz) / ray.dz;
        const double x = ray.ox + distance * ray.dx, y = ray.oy + distance * ray.dy;
        if (distance > 0.0 && x * x + y * y <= radius * radius)
            return (Hit){distance, fabs(ray.dz)};
    }
    return NO_HIT;
}

static inline Hit hit_plane(double half_width, double half_height, LocalRay ray)
{
    if (fabs(ray.dz) < PARALLEL)
        return NO_HIT;
    const double distance = -ray.oz / ray.dz;
    if (!(distance > 0.0 && distance < FAR))
        return NO_HIT;
    if (fabs(ray.ox + distance * ray.dx) > half_width || fabs(ray.oy + distance * ray.dy) > half_height)
        return NO_HIT;
    return (Hit){distance, fabs(ray.dz)};
}

/* Returns where the ray along the unit vector (x, y, z) first meets a body in the sonar's frame; NO_HIT where it does
   not. A body around the sonar is not met. */
static inline Hit hit(const Body *body, double x, double y, double z)
{
    if (body->kind == SPHERE)
        return hit_sphere(body, x, y, z);
    const LocalRay ray = local_ray(body, x, y, z);
    if (body->kind == CYLINDER)
        return hit_cylinder(body->half[0], body->half[2], ray);
    return hit_plane(body->half[0], body->half[1], ray);
}

/* Returns the radius of a body's bounding sphere. */
static inline double bounding_radius(const Body *body)
{
    if (body->kind == SPHERE)
        return body->half[0];
    return hypot(body->half[0], body->kind == CYLINDER ? body->half[2] : body->half[1]);
}

#endif
