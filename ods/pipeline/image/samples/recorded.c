/* Samples without data, in cells of the image that are means of several. */

#include "ods/pipeline/image/missing/fill.h"
#include "ods/pipeline/image/samples/recorded.h"

/* Returns the mean of those of samples `begin` to `stop` - 1 that hold data. */
static double mean_of_data(const float *row, const bool *gaps, int64_t begin, int64_t stop)
{
    double total = 0.0;
    int64_t count = 0;
    for (int64_t k = begin; k < stop; k++)
        if (!gaps[k]) {
            total += row[k];
            count++;
        }
    return total / (double)count;
}

static void store_sample(char *row, char type, int64_t column, double value)
{
    if (type == 'B')
        ((uint8_t *)row)[column] = (uint8_t)value;
    else if (type == 'H')
        ((uint16_t *)row)[column] = (uint16_t)value;
    else
        ((float *)row)[column] = (float)value;
}

/* Gives the samples without data of a cell that has some, from `first` on, the mean of those around that hold data. */
static void lend_to_cell(const float *row, const bool *gaps, int64_t first, Recorded recorded, char *out)
{
    const int64_t stop = first + recorded.stride, reach = NEIGHBOURS * recorded.stride;
    int64_t lost = 0;
    for (int64_t j = first; j < stop; j++)
        lost += gaps[j];
    if (lost == 0 || lost == recorded.stride)
        return;
    for (int64_t j = first; j < stop; j++)
        if (gaps[j]) {
            const int64_t begin = larger_i(0, j - reach), end = smaller_i(recorded.samples.samples, j + reach + 1);
            store_sample(out, recorded.samples.type, j, mean_of_data(row, gaps, begin, end));
        }
}

/* Gives samples without data, in cells that have some, the mean of those within NEIGHBOURS cells that hold data.
   out: a copy of the samples. */
KERNEL(lend_samples, RECORDED ", rows out u1|u2|f4[beams,:] out")
{
    const Recorded recorded = recorded_at(arguments);
    const Samples samples = recorded.samples, out = SAMPLES(arguments_of(RECORDED));
    float *row = SCRATCH(float, samples.samples);
    if (recorded.missing.marks == NULL || out.type != samples.type || out.samples != samples.samples)
        return;
    for (int64_t b = 0; b < recorded.beams; b++) {
        const bool *gaps = recorded.missing.marks + b * recorded.missing.stride;
        load_samples(samples, b, 0, 1, samples.samples, row);
        for (int64_t k = 0; k < recorded.columns; k++) {
            const int64_t first = recorded.origin[k];
            if (first >= 0 && first + recorded.stride <= samples.samples)
                lend_to_cell(row, gaps, first, recorded, (char *)out.data + b * out.row_bytes);
        }
    }
}

/* Marks the cells of the image whose samples all have no data; returns whether there are any. */
KERNEL_BOOL(cells_without_data, RECORDED ", out b1[beams,columns] cells")
{
    const Recorded recorded = recorded_at(arguments);
    const int64_t samples = recorded.samples.samples;
    bool any = false;
    bool *cells = ARRAY(bool, arguments_of(RECORDED));
    memset(cells, false, (size_t)(recorded.beams * recorded.columns));
    for (int64_t b = 0; b < recorded.beams && recorded.missing.marks != NULL; b++, cells += recorded.columns) {
        const bool *gaps = recorded.missing.marks + b * recorded.missing.stride;
        if (next_gap(gaps, 0, samples).begin == samples)
            continue;
        for (int64_t k = 0; k < recorded.columns; k++) {
            const int64_t first = recorded.origin[k], stop = first + recorded.stride;
            bool lost = first >= 0 && stop <= samples;
            for (int64_t j = first; lost && j < stop; j++)
                lost = gaps[j];
            cells[k] = lost;
            any |= lost;
        }
    }
    return any;
}
