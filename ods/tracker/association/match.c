/* What one image says about the objects, once its echoes are given to them (match.py). */

#include "ods/tracker/association/hypotheses/gating.h"
#include "ods/tracker/association/split_merged.h"
#include "ods/tracker/measurement/coverage/normal.h"
#include "ods/tracker/measurement/model.h"
#include "ods/tracker/existence/evidence.h"

/* An echo that is so many times as wide as its object, taken to have at least this radius, is joined with neighbours':
   it sets in as the first of these does. */
#define JOINED 1.6
#define LEAST_JOINED_M 1.5
/* Of a table whose rows have names. */
#define ROWS(NAMES) ((int64_t)(sizeof(NAMES) / sizeof(double *)))

/* An image of m echoes, and what is expected of n objects in it. */
typedef struct {
    const double *table; /* (12, m) */
    EchoRows echoes;
    int64_t m;
    const double *per_m2; /* (m,) false alarms at each echo */
    Bodies bodies;
    const double *visibility;     /* (n,) that an object gives echoes just now, */
    double detection_probability; /* and that it then has one in this image */
} Image;

/* Finds the `loose` echoes inside the circles of confirmed objects, which are loose no longer; returns those that are
   more likely parts of these than false alarms: the rest is more likely false alarms inside a silent object's circle.
   */
static Parts parts_inside(const Image *image, bool *loose)
{
    const Confirmed confirmed = confirmed_of(&image->bodies);
    Parts parts = room_for_parts(image->m);
    for (int64_t j = 0; j < image->m; j++) {
        const int64_t i = loose[j] ? whole_of(&image->echoes, j, &image->bodies, &confirmed) : -1;
        if (i < 0)
            continue;
        loose[j] = false;
        const double by_chance = image->per_m2[j] * PI * square(image->bodies.radius[i]);
        const double llr = -log(smaller(1.0, by_chance));
        if (llr + score_over_llr(image->visibility[i], image->detection_probability) > 0.0)
            add_part(&parts, i, j, llr);
    }
    return parts;
}

/* Puts together what is seen only in parts: `split`, and those of the pairs whose echo is a part as well, as it is
   smaller than its object; says of which pairs that is, (pairs,). An object that has an echo of its own as a whole is not seen in parts. */
static Together seen_in_parts(const Image *image, const Hypotheses *pairs, const Parts *split, bool *also_part)
{
    const EchoRows *echoes = &image->echoes;
    bool *in_parts = ZEROS(bool, image->bodies.n);
    Parts parts = room_for_parts(pairs->count + split->count);
    for (int64_t part = 0; part < split->count; part++)
        in_parts[split->objects[part]] = true;
    for (int64_t k = 0; k < pairs->count; k++) {
        const int64_t i = pairs->objects[k], j = pairs->echoes[k];
        const double largest = echoes->radius[j] + BEYOND_CHANCE * echoes->sigma_radius[j];
        also_part[k] = in_parts[i] && largest < image->bodies.radius[i];
        if (also_part[k])
            add_part(&parts, i, j, pairs->llr[k]);
    }
    for (int64_t k = 0; k < pairs->count; k++)
        if (!also_part[k])
            in_parts[pairs->objects[k]] = false;
    for (int64_t part = 0; part < split->count; part++)
        if (in_parts[split->objects[part]])
            add_part(&parts, split->objects[part], split->echoes[part], split->llr[part]);
    return put_together(&parts, echoes, image->bodies.n);
}

/* Objects seen and what they are seen by: see `ExplainedEchoes` of match.py. */
typedef struct {
    int64_t *objects;
    double *llr, *off_centre;
    double *table; /* (12, count) */
    int64_t count;
} Shown;

/* Fills in the pairs that are not `also_part`, each with its column of `assigned`, (12, pairs), and then what is seen
   in parts. */
static void fill_shown(Shown *shown, const Image *image, const Hypotheses *pairs, const double *assigned,
                       const bool *also_part, const Together *parts)
{
    const int64_t wholes = shown->count - parts->count;
    int64_t *kept = SCRATCH(int64_t, wholes);
    for (int64_t k = 0, place = 0; k < pairs->count; k++) {
        if (also_part[k])
            continue;
        shown->objects[place] = pairs->objects[k], shown->llr[place] = pairs->llr[k], shown->off_centre[place] = 0.0;
        kept[place++] = k;
    }
    for (int64_t k = 0; k < parts->count; k++) {
        const int64_t i = parts->objects[k];
        shown->objects[wholes + k] = i, shown->llr[wholes + k] = parts->llr[k];
        shown->off_centre[wholes + k] = square(PARTS * image->bodies.radius[i]);
    }
    for (int64_t row = 0; row < ROWS(EchoRows); row++) {
        double *out = shown->table + row * shown->count;
        for (int64_t k = 0; k < wholes; k++)
            out[k] = assigned[row * pairs->count + kept[k]];
        for (int64_t k = 0; k < parts->count; k++)
            out[wholes + k] = image->table[row * image->m + parts->first[k]];
    }
    const EchoRows echoes = echo_rows(shown->table, shown->count);
    memcpy(echoes.range_m + wholes, parts->range_m, sizeof(double) * (size_t)parts->count);
    memcpy(echoes.bearing + wholes, parts->bearing, sizeof(double) * (size_t)parts->count);
}

/* What the image may show of n objects: fields of `FieldOfView`. */
typedef struct {
    const double *watched;
    const bool *inside, *skipped;
} View;

/* Sets how the echo k of object i sets in, which can be of no other object and is all of it. */
static void fill_in_how_it_sets_in(const ScanEvidence *evidence, int64_t i, const EchoRows *echoes, int64_t k,
                                   const Bodies *bodies)
{
    if (!(echoes->strength[k] > 0.0))
        return;
    const bool joined = echoes->radius[k] > JOINED * larger(LEAST_JOINED_M, bodies->radius[i]);
    evidence->onset[i] = joined ? 0.0 : echoes->onset[k];
    evidence->leading_edge[i] = joined ? 0.0 : echoes->front[k];
}

/* Fills in the evidence of n objects; `merged`: of `find_merged`: above 0, a missing echo may be in that of a neighbour;
   `expected`: probability that one that is watched has an echo. */
static void fill_evidence(const ScanEvidence *evidence, const Shown *shown, const Bodies *bodies, View view,
                          const bool *hit, const double *merged, double expected)
{
    const EchoRows echoes = echo_rows(shown->table, shown->count);
    memset(evidence->llr, 0, sizeof(double) * (size_t)(ROWS(ScanEvidence) * bodies->n));
    for (int64_t i = 0; i < bodies->n; i++) {
        if (hit[i] || merged[i] == 0.0)
            evidence->watched[i] = bodies->confirmed[i] ? view.watched[i] : view.inside[i] && !view.skipped[i];
        evidence->expected[i] = evidence->watched[i] * expected;
    }
    for (int64_t k = 0; k < shown->count; k++) {
        const int64_t i = shown->objects[k];
        evidence->llr[i] = shown->llr[k];
        if (shown->off_centre[k] == 0.0 && merged[i] == 0.0 && echoes.cut[k] == 0.0)
            fill_in_how_it_sets_in(evidence, i, &echoes, k, bodies);
    }
}

/* Fills in which echoes no confirmed object explains, (m,), by the pairs. */
static void fill_free(bool *is_free, int64_t m, const Hypotheses *pairs, const bool *confirmed)
{
    memset(is_free, 1, (size_t)m * sizeof *is_free);
    for (int64_t k = 0; k < pairs->count; k++)
        if (confirmed[pairs->objects[k]])
            is_free[pairs->echoes[k]] = false;
}

/* Says what is seen of n objects, as wholes or only in parts, and which of m echoes nobody explains: see `match.shown`.

   assigned, explained: of the `Assignment` of these pairs; per_m2: of `ClutterDensity`. Fills in the fields of
   `ExplainedEchoes`, as many numbers as `counts` says: of objects shown, the table (12, k) from its first number on,
   and of unexplained echoes. Returns false for pairs of no objects or echoes. */
KERNEL_BOOL(
    match_shown, HYPOTHESES
    ", f8[12,p] assigned, b1[m] explained, f8[12,m] echo_table, f8[m] per_m2, f8[8,n] predicted, "
    "f8[3,n] position, f8[n] radius, b1[n] confirmed, f8[n] visibility, f8[n] watched, b1[n] inside, b1[n] skipped, "
    "float detection_probability, out i8[room] objects, out f8[12,room] table, out f8[room] llr, "
    "out f8[room] off_centre, out i8[m] unexplained, out b1[n] hit, out f8[5,n] evidence, out b1[m] free, out i8[2] counts")
{
    const Hypotheses pairs = hypotheses_from(arguments, 0);
    const int64_t n = SIZE(10, 0), m = SIZE(5, 0);
    double *table = ARRAY(double, 6), *merged = SCRATCH(double, n);
    const Bodies bodies = {predicted_rows(ARRAY(double, 8), n), ARRAY(const double, 10), ARRAY(const bool, 11), n};
    const Image image = {table,  echo_rows(table, m),     m,        ARRAY(const double, 7),
                         bodies, ARRAY(const double, 12), FLOAT(16)};
    const View view = {ARRAY(const double, 13), ARRAY(const bool, 14), ARRAY(const bool, 15)};
    bool *also_part = SCRATCH(bool, pairs.count), *loose = SCRATCH(bool, m), *hit = ARRAY(bool, 22);
    int64_t *unexplained = ARRAY(int64_t, 21), *counts = ARRAY(int64_t, 25), left = 0;
    for (int64_t k = 0; k < pairs.count; k++)
        if (!is_pair(&pairs, k, n, m))
            return false;
    for (int64_t j = 0; j < m; j++)
        loose[j] = !ARRAY(const bool, 5)[j];
    const Parts split = parts_inside(&image, loose);
    const Together parts = seen_in_parts(&image, &pairs, &split, also_part);
    Shown shown = {ARRAY(int64_t, 17), ARRAY(double, 19), ARRAY(double, 20), ARRAY(double, 18), parts.count};
    for (int64_t k = 0; k < pairs.count; k++)
        shown.count += !also_part[k];
    if (shown.count > SIZE(17, 0))
        return false;
    fill_shown(&shown, &image, &pairs, ARRAY(const double, 4), also_part, &parts);
    memset(hit, 0, (size_t)n * sizeof *hit);
    for (int64_t k = 0; k < shown.count; k++)
        hit[shown.objects[k]] = true;
    find_merged(&bodies, ARRAY(const double, 9), hit, view.watched, merged);
    const ScanEvidence evidence = evidence_rows(ARRAY(double, 23), n);
    fill_evidence(&evidence, &shown, &bodies, view, hit, merged, FLOAT(16));
    for (int64_t k = 0; k < shown.count; k++)
        shown.off_centre[k] += merged[shown.objects[k]];
    for (int64_t j = 0; j < m; j++)
        if (loose[j])
            unexplained[left++] = j;
    fill_free(ARRAY(bool, 24), m, &pairs, bodies.confirmed);
    counts[0] = shown.count, counts[1] = left;
    return true;
}
