/* From regions to echoes: levels, extents, near edge, and the circle that stands for each object. */

#include "ods/pipeline/measure/cut_off.h"
#include "ods/pipeline/measure/sigmas/features.h"
#include "ods/pipeline/measure/onset.h"
#include "ods/pipeline/measure/response.h"
#include "ods/pipeline/measure/sigmas/sigmas.h"

/* Levels and widths of an image. */
typedef struct {
    double background;
    double point;    /* width of a point, columns, */
    double response; /* and without what the bottom's own relief adds to it */
} Speckle;

/* Standard deviations of what is not seen, m. */
typedef struct {
    double hidden_m; /* how much nearer the body of a fragment begins */
    double beside_m; /* of the place across the line of sight, at most */
} Doubt;

/* Asks for the cells of a region's runs, and the samples they were made of: the cache cannot foresee them. */
static void fetch(const Region *image, Recorded recorded, const Run *runs, const Run *end)
{
    for (const Run *run = runs; run < end && run->region == runs->region; run++) {
        if (run->beam < 0 || run->beam >= image->beams || run->first < 0 || run->first >= image->columns)
            continue;
        const int64_t sample = recorded.origin[run->first] * sample_bytes(recorded.samples.type);
        __builtin_prefetch(row_of(image, run->beam) + run->first);
        __builtin_prefetch(recorded.samples.data + run->beam * recorded.samples.row_bytes + sample);
    }
}

/* Fills in peak, mean, snr_db and cells, and beam: the peak intensity over the background's of each beam. */
static void find_levels(const Region *region, double background, Echo *echo, double *beam)
{
    double total = 0.0, peak = 0.0;
    int64_t cells = 0;
    for (int64_t i = 0; i < region->count; i++) {
        const Run run = region->runs[i];
        const float *row = row_of(region, run.beam);
        float best = 0.0f;
        for (int64_t j = run.first; j < run.stop; j++) {
            total += row[j];
            best = larger_f(row[j], best);
        }
        cells += run.stop - run.first;
        peak = larger(best, peak);
        double *intensity = &beam[run.beam - region->low];
        *intensity = larger((double)best * best - background * background, *intensity);
    }
    echo->peak = peak / background;
    echo->mean = total / (double)cells / background;
    echo->snr_db = 20.0 * log10(larger(1e-6, echo->peak));
    echo->cells = cells;
}

/* Returns the highest level over the mean of what the runs end at, the lower end of each. */
static double contrast_of(const Region *region, double peak)
{
    double total = 0.0;
    for (int64_t i = 0; i < region->count; i++) {
        const Run run = region->runs[i];
        const float *row = row_of(region, run.beam);
        total += smaller_f(row[run.stop - 1], row[run.first]);
    }
    return larger(1.0, peak * (double)region->count / larger(1e-30, total));
}

/* Fills in levels, extents, near edge and circle of an echo, and features: how well the circle is known. */
static Doubt measure_one(const Region *region, Speckle speckle, const FanTable *fan, Echo *echo, double *features,
                         int64_t of_features)
{
    double *beam = ZEROS(double, region->high - region->low + 1);
    const Ends ends = {SCRATCH(double, region->count), SCRATCH(double, region->count)};
    find_levels(region, speckle.background, echo, beam);
    find_ends(region, fan, ends);
    const Depth depth = depth_of(region, ends, speckle.background, echo->mean, fan);
    const Crest crest = {beam, echo->peak, contrast_of(region, echo->peak * speckle.background)};
    Shape shape;
    Outline outline;
    const Circle circle = circle_of(region, ends, &depth, crest, fan, &outline, &shape);
    echo->range_extent_m = (double)(region->stop - region->first) * fan->dr_m; /* as it was detected */
    echo->bearing_extent_rad = fan->borders_rad[region->high + 1] - fan->borders_rad[region->low];
    echo->near_m = depth.near_m;
    echo->range_m = circle.range_m, echo->bearing_rad = circle.bearing_rad, echo->radius_m = circle.radius_m;
    echo->elevation_rad = fan->elevation_rad;
    echo->half_length_m = outline.half_length_m, echo->half_width_m = outline.half_width_m;
    echo->axis_rad = outline.axis_rad;
    find_features(echo, &depth, &shape, speckle.point * fan->dr_m, fan->dr_m, features, of_features);
    return (Doubt){depth.hidden_m, shape.beside_m};
}

/* Fills in the standard deviations.

   That of the near edge is at least what of a fragment may be hidden. The centre is not better known than it. */
static void claim(Sigmas sigmas, Doubt doubt, Echo *echo)
{
    echo->sigma_near_m = larger(doubt.hidden_m, sigmas.near_m);
    echo->sigma_radius_m = sigmas.radius_m;
    echo->sigma_bearing_rad = sigmas.bearing_rad;
    echo->sigma_range_m = larger(echo->sigma_near_m, sigmas.range_m);
}

/* Fills in the highest recorded sample, 0 where all are negative, and whether, and how, the echo is cut off. */
static void finish(const Region *region, Recorded recorded, double response, Echo *echo)
{
    for (int64_t i = 0; i < region->count; i++)
        echo->amplitude = larger(highest_sample(recorded, region->runs[i]), echo->amplitude);
    const bool beside = is_cut_beside(recorded, region), in_range = is_cut_in_range(region);
    echo->cut = beside || in_range;
    if (echo->cut)
        widen(echo, beside, in_range);
    else
        echo->onset = onset_of_region(region, response);
}

/* Returns a sum that is not finite where a number of an echo is not. */
static double sum_of(const Echo *echo)
{
    return echo->range_m + echo->bearing_rad + echo->radius_m + echo->peak + echo->mean + echo->snr_db
           + echo->sigma_range_m + echo->sigma_bearing_rad + echo->sigma_radius_m + echo->amplitude + echo->near_m
           + echo->sigma_near_m + echo->onset + echo->half_length_m + echo->half_width_m + echo->axis_rad;
}

/* Fills echoes with those of the regions, which are numbered from 1, and features with how well their
   circles are known; both are zero before. Returns the width of a point, columns; NaN where an echo has numbers that are
   not finite. */
KERNEL_FLOAT(measure_echoes, "f4[beams,columns] image, r16[runs] runs, float background, " RECORDED ", " FAN_TABLE ", "
                             LAWS ", out " ECHO "[echoes] echoes, out f8[echoes,features] features")
{
    const double background = FLOAT(2);
    Region region = {.image = ARRAY(const float, 0), .beams = SIZE(0, 0), .columns = SIZE(0, 1)};
    const Speckle speckle = {background, width_of_point(region.image, region.beams, region.columns, background),
                             width_of_response(region.image, region.beams, region.columns, background)};
    const Run *runs = ARRAY(const Run, 1), *end = runs + SIZE(1, 0);
    const Recorded recorded = recorded_at(arguments += 3);
    const FanTable fan = fan_table_at(arguments += arguments_of(RECORDED));
    const Laws laws = laws_at(arguments += arguments_of(FAN_TABLE));
    const Argument *laws_first = arguments;
    Echo *echo = (Echo *)(arguments += arguments_of(LAWS))->data;
    double *features = ARRAY(double, 1), sum = 0.0;
    const int64_t of_features = SIZE(1, 1);
    if (!fits(laws.sigmas, laws_first, of_features) || !fits(laws.range, laws_first + 2, of_features))
        return NAN;
    for (int64_t k = 0; k < SIZE(0, 0); k++, echo++, features += of_features) {
        region.runs = runs;
        while (runs < end && runs->region == k + 1)
            runs++;
        region.count = runs - region.runs;
        fetch(&region, recorded, runs, end);
        if (!is_within(&region))
            continue;
        const Doubt doubt = measure_one(&region, speckle, &fan, echo, features, of_features);
        const double point_m = speckle.point * fan.dr_m;
        claim(sigmas_of_features(features, &laws, point_m, doubt.beside_m, echo->range_m, fan.dr_m), doubt, echo);
        finish(&region, recorded, speckle.response, echo);
        sum += sum_of(echo);
    }
    return isfinite(sum) ? speckle.point : NAN;
}

/* Parts echoes: fills out with those of ranges from `from_m` to less than `to_m`, first those that are not faint, then
   those faint ones whose front is likelier than `least_front`; counts: how many of either. */
KERNEL(part_echoes, ECHO "[echoes] echoes, b1[echoes] faint, float from_m, float to_m, float least_front, "
                    "out " ECHO "[echoes] out, out i8[2] counts")
{
    const Echo *echoes = ARRAY(const Echo, 0);
    const bool *faint = ARRAY(const bool, 1);
    Echo *out = ARRAY(Echo, 5);
    int64_t *counts = ARRAY(int64_t, 6), filled = 0;
    for (int64_t kind = 0; kind < 2; kind++) {
        const int64_t before = filled;
        for (int64_t k = 0; k < SIZE(0, 0); k++)
            if (faint[k] == (kind == 1) && echoes[k].range_m >= FLOAT(2) && echoes[k].range_m < FLOAT(3)
                && (kind == 0 || echoes[k].front > FLOAT(4)))
                out[filled++] = echoes[k];
        counts[kind] = filled - before;
    }
}
