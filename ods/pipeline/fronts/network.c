/* A small convolutional network (network.py). Two thirds of what its layers make are 0: only the rest is weighed. */

#include "ods/pipeline/filter/rows/lanes.h"

typedef int32_t EightPlaces __attribute__((vector_size(32), aligned(4), may_alias));

/* What a layer made of a window, (beams, cells, channels). */
typedef struct {
    float *values;
    uint8_t *marks;  /* which values are above 0, */
    int32_t *active; /* and their places */
    const EightPlaces *lists; /* as `list_bits` makes them */
    int32_t *begins; /* (beams * cells + 1,) which of `active` is the first of each cell */
    int64_t beams, cells, channels;
} Made;

/* Weights (inputs, outputs) and bias of a layer. */
typedef struct {
    const float *weights, *bias;
    int64_t inputs, outputs;
} Dense;

/* `Convolution` of network.py. */
typedef struct {
    Dense dense;
    int64_t beams, cells;           /* that are seen of each place, */
    int64_t step_beams, step_cells; /* and from one place to the next */
} Convolution;

#define DENSE(OUTPUTS) "f4[:," OUTPUTS "] weights, f4[" OUTPUTS "] bias"
#define CONVOLUTION(OUTPUTS) DENSE(OUTPUTS) ", int beams, int cells, int step_beams, int step_cells"
#define CONVOLUTIONS 3
/* Places that the first of them weighs together. */
#define PLACES 4

/* Outputs of a layer that are weighed together: each but the last layer has a multiple of so many. */
#define OUTPUT_BLOCK (2 * LANES)

/* `Network` of network.py. */
typedef struct {
    Convolution convolutions[CONVOLUTIONS];
    Dense hidden, last;
} Network;

#define NETWORK \
    CONVOLUTION("first") ", " CONVOLUTION("second") ", " CONVOLUTION("third") ", " DENSE("hidden") ", " DENSE("1")

static Dense dense_at(const Argument *arguments)
{
    return (Dense){ARRAY(const float, 0), ARRAY(const float, 1), SIZE(0, 0), SIZE(0, 1)};
}

static Convolution convolution_at(const Argument *arguments)
{
    const Dense dense = dense_at(arguments);
    arguments += arguments_of(DENSE("1"));
    return (Convolution){dense, larger_i(INT(0), 1), larger_i(INT(1), 1), larger_i(INT(2), 1), larger_i(INT(3), 1)};
}

/* arguments: from its first one on. */
static Network network_at(const Argument *arguments)
{
    Network network;
    for (int k = 0; k < CONVOLUTIONS; k++, arguments += arguments_of(CONVOLUTION("1")))
        network.convolutions[k] = convolution_at(arguments);
    network.hidden = dense_at(arguments);
    network.last = dense_at(arguments + arguments_of(DENSE("1")));
    return network;
}

/* Returns room for what a layer makes, and for as many channels of PLACES more. */
static Made new_made(int64_t beams, int64_t cells, int64_t channels, const EightPlaces *lists)
{
    const int64_t size = beams * cells * channels;
    return (Made){.values = SCRATCH(float, size + PLACES * channels), .marks = SCRATCH(uint8_t, size), .lists = lists,
                  .active = SCRATCH(int32_t, size + 8), .begins = SCRATCH(int32_t, beams * cells + 1),
                  .beams = beams, .cells = cells, .channels = channels};
}

/* Fills lists, all 0 before, with the bits of each byte that are set, lowest first. */
static void list_bits(EightPlaces *lists)
{
    for (int byte = 0; byte < 256; byte++)
        for (int bit = 0, count = 0; bit < 8; bit++)
            if (byte >> bit & 1)
                lists[byte][count++] = bit;
}

/* Adds the places from `place` on of eight marks, 1 or 0, to a list that has room for eight; returns how many. */
static inline int32_t add_places(const uint8_t *marks, const EightPlaces *lists, int32_t place, int32_t *list)
{
    uint64_t set;
    memcpy(&set, marks, sizeof set);
    set = set * 0x0102040810204080 >> 56; /* gathers the lowest bits of eight bytes in one, the first one lowest */
    *(EightPlaces *)list = lists[set] + place;
    return __builtin_popcountll(set);
}

/* Notes which values are above 0; the others count as 0. */
static void note(Made *made)
{
    const int64_t cells = made->beams * made->cells, size = cells * made->channels;
    const float *restrict values = made->values;
    uint8_t *restrict marks = made->marks;
    int32_t count = 0, place = 0;
    for (int64_t k = 0; k < size; k++)
        marks[k] = !(values[k] <= 0.0f); /* NaN, too */
    for (int64_t cell = 0; cell < cells; cell++) {
        const int32_t end = place + (int32_t)made->channels;
        made->begins[cell] = count;
        for (; place < end; place += 8)
            count += add_places(marks + place, made->lists, place, made->active + count);
    }
    made->begins[cells] = count;
}

/* Places that follow one another, and the row of weights that belongs to place 0. */
typedef struct {
    const int32_t *begin, *end;
    int64_t row;
} Part;

/* Fills some lanes of outputs, from `first` on, with the bias and the values at the places of parts times their
   weights; by turns in two sums, as one would wait for itself. */
static inline __attribute__((always_inline)) void weigh_lanes(const float *values, const Part *parts, int64_t count,
                                                              Dense layer, int64_t first, const int lanes, float *out)
{
    const float *weights = layer.weights + first;
    Lanes even[LANES_OF_BLOCK], odd[LANES_OF_BLOCK];
#pragma GCC unroll 4
    for (int i = 0; i < lanes; i++) {
        even[i] = load(layer.bias + first + i * LANES);
        odd[i] = (Lanes){0};
    }
    for (const Part *part = parts; part < parts + count; part++) {
        const int32_t *place = part->begin;
        for (; place + 1 < part->end; place += 2) {
            const float *one = weights + (place[0] + part->row) * layer.outputs;
            const float *other = weights + (place[1] + part->row) * layer.outputs;
#pragma GCC unroll 4
            for (int i = 0; i < lanes; i++) {
                even[i] += values[place[0]] * load(one + i * LANES);
                odd[i] += values[place[1]] * load(other + i * LANES);
            }
        }
        if (place < part->end) {
            const float *one = weights + (place[0] + part->row) * layer.outputs;
#pragma GCC unroll 4
            for (int i = 0; i < lanes; i++)
                even[i] += values[place[0]] * load(one + i * LANES);
        }
    }
#pragma GCC unroll 4
    for (int i = 0; i < lanes; i++)
        *(Lanes *)(out + first + i * LANES) = even[i] + odd[i];
}

/* Fills out (outputs,) with the bias and the values at the places of parts times their weights. */
static void weigh(const float *values, const Part *parts, int64_t count, Dense layer, float *out)
{
    int64_t first = 0;
    for (; first + 2 * OUTPUT_BLOCK <= layer.outputs; first += 2 * OUTPUT_BLOCK)
        weigh_lanes(values, parts, count, layer, first, 4, out);
    if (first < layer.outputs)
        weigh_lanes(values, parts, count, layer, first, 2, out);
}

/* The levels of a window, of which none is 0, with the zeros around them that the first layer sees. */
typedef struct {
    float *levels;
    int64_t width; /* cells from one beam to the next */
} Window;

static Window new_window(int64_t beams, int64_t cells, Convolution layer)
{
    const int64_t width = cells + layer.cells + PLACES * layer.step_cells;
    return (Window){ZEROS(float, (beams + layer.beams) * width), width};
}

/* Fills two lanes of outputs, from `first` on, of PLACES places with the bias and the levels that they see times their
   weights. levels: what the first of them sees. */
static void weigh_levels(const float *levels, int64_t width, const Convolution *layer, int64_t first, float *out)
{
    const int64_t outputs = layer->dense.outputs;
    const float *weights = layer->dense.weights + first;
    Lanes left[PLACES], right[PLACES];
#pragma GCC unroll 4
    for (int k = 0; k < PLACES; k++) {
        left[k] = load(layer->dense.bias + first);
        right[k] = load(layer->dense.bias + first + LANES);
    }
    for (int64_t b = 0; b < layer->beams; b++)
        for (int64_t c = 0; c < layer->cells; c++, weights += outputs)
#pragma GCC unroll 4
            for (int k = 0; k < PLACES; k++) {
                left[k] += levels[b * width + c + k * layer->step_cells] * load(weights);
                right[k] += levels[b * width + c + k * layer->step_cells] * load(weights + LANES);
            }
#pragma GCC unroll 4
    for (int k = 0; k < PLACES; k++) {
        *(Lanes *)(out + k * outputs + first) = left[k];
        *(Lanes *)(out + k * outputs + first + LANES) = right[k];
    }
}

/* Fills out, which has room for PLACES more, with what the first convolution makes of a window. */
static void convolve_window(Window window, const Convolution *layer, Made *out)
{
    for (int64_t b = 0; b < out->beams; b++) {
        for (int64_t c = 0; c < out->cells; c += PLACES) {
            const float *levels = window.levels + b * layer->step_beams * window.width + c * layer->step_cells;
            float *values = out->values + (b * out->cells + c) * out->channels;
            for (int64_t first = 0; first < out->channels; first += OUTPUT_BLOCK)
                weigh_levels(levels, window.width, layer, first, values);
        }
    }
    note(out);
}

/* Fills parts with what a place of a convolution sees of a layer, from beam and cell on; returns how many. Beyond the
   cells that it has there are zeros. */
static int64_t parts_of(const Made *seen, const Convolution *layer, int64_t beam, int64_t cell, Part *parts)
{
    const int64_t begin = larger_i(cell, 0), end = larger_i(smaller_i(cell + layer->cells, seen->cells), begin);
    int64_t count = 0;
    for (int64_t k = larger_i(-beam, 0); k < layer->beams && beam + k < seen->beams; k++) {
        const int64_t row = (beam + k) * seen->cells;
        parts[count++] = (Part){seen->active + seen->begins[row + begin], seen->active + seen->begins[row + end],
                                (k * layer->cells - row - cell) * seen->channels};
    }
    return count;
}

/* Fills out with what a convolution makes of a layer. */
static void convolve(const Made *seen, const Convolution *layer, Made *out)
{
    Part *parts = SCRATCH(Part, layer->beams);
    float *values = out->values;
    for (int64_t b = 0; b < out->beams; b++)
        for (int64_t c = 0; c < out->cells; c++, values += out->channels) {
            const int64_t beam = b * layer->step_beams - layer->beams / 2;
            const int64_t cell = c * layer->step_cells - layer->cells / 2;
            weigh(seen->values, parts, parts_of(seen, layer, beam, cell, parts), layer->dense, values);
        }
    note(out);
}

/* Fills out with what a layer of all values makes of all that the one before made. */
static void weigh_all(const Made *seen, Dense layer, Made *out)
{
    const Part all = {seen->active, seen->active + seen->begins[seen->beams * seen->cells], 0};
    weigh(seen->values, &all, 1, layer, out->values);
    note(out);
}

/* Returns how many places there are of `size` cells, zeros around them included, `around` of which are seen of each. */
static int64_t places_of(int64_t size, int64_t around, int64_t step)
{
    return larger_i(size + around / 2 * 2 - around, -1) / step + 1;
}

/* Fills made, (CONVOLUTIONS + 1,), with room for what all layers but the last one make of a window, (beams, cells).
   Returns whether the weights fit. */
static bool prepare(const Network *network, int64_t beams, int64_t cells, Made *made)
{
    int64_t channels = 1;
    EightPlaces *lists = ZEROS(EightPlaces, 256);
    list_bits(lists);
    for (int k = 0; k < CONVOLUTIONS; k++) {
        const Convolution layer = network->convolutions[k];
        if (layer.dense.inputs != layer.beams * layer.cells * channels || layer.dense.outputs % OUTPUT_BLOCK != 0)
            return false;
        beams = places_of(beams, layer.beams, layer.step_beams);
        cells = places_of(cells, layer.cells, layer.step_cells);
        channels = layer.dense.outputs;
        made[k] = new_made(beams, cells, channels, lists);
    }
    made[CONVOLUTIONS] = new_made(1, 1, network->hidden.outputs, lists);
    return network->hidden.inputs == beams * cells * channels && network->hidden.outputs % OUTPUT_BLOCK == 0
           && network->last.inputs == network->hidden.outputs;
}

/* Returns the score of a window. made: as `prepare` makes it. */
static float score(const Network *network, Window window, Made *made)
{
    Made *const seen = &made[CONVOLUTIONS - 1], *const hidden = seen + 1;
    float score = network->last.bias[0];
    convolve_window(window, &network->convolutions[0], &made[0]);
    for (int k = 1; k < CONVOLUTIONS; k++)
        convolve(&made[k - 1], &network->convolutions[k], &made[k]);
    weigh_all(seen, network->hidden, hidden);
    for (int64_t k = 0; k < hidden->begins[1]; k++)
        score += hidden->values[hidden->active[k]] * network->last.weights[hidden->active[k]];
    return score;
}

/* Fills scores with the logarithm of the odds of a body's front against the bed's; NaN where the weights do not fit. */
LONG_KERNEL(score_fronts, "f4[windows,beams,cells] windows, float unit, " NETWORK ", out f4[windows] scores")
{
    const int64_t beams = SIZE(0, 1), cells = SIZE(0, 2);
    const float *levels = ARRAY(const float, 0), unit = (float)FLOAT(1);
    const Network network = network_at(arguments + 2);
    const Convolution layer = network.convolutions[0];
    float *scores = ARRAY(float, 2 + arguments_of(NETWORK));
    Made made[CONVOLUTIONS + 1];
    const bool fits = beams > 0 && cells > 0 && prepare(&network, beams, cells, made);
    const Window window = fits ? new_window(beams, cells, layer) : (Window){NULL, 0};
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        scores[k] = NAN;
        if (!fits)
            continue;
        for (int64_t b = 0; b < beams; b++, levels += cells)
            for (int64_t c = 0; c < cells; c++)
                window.levels[(b + layer.beams / 2) * window.width + c + layer.cells / 2] = levels[c] / unit;
        scores[k] = score(&network, window, made);
    }
}
