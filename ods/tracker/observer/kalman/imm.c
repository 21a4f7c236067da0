/* North and east in one filter (ud_filter.h), and several of them that interact: see imm.py.

   The models exchange their states as seldom as is good enough: it costs as much as correcting all of them, and tells next
   to nothing from one ping to the next. What is done to the objects that a ping shows is done to LANES of them at a time:
   their columns are copied together, so that each instruction takes several. */

#include "ods/tracker/observer/kalman/ud_filter.h"

/* So long after their last exchange, at the next measurement, models exchange their states, s. */
#define EXCHANGE_S 1.0
/* Each new object exchanges so much of that time later than the one before: never many of them in the same ping. */
#define GOLDEN 0.618
/* Of what a model has after an exchange, a smaller share that came from another model is left out: a wide one that hardly
   anything speaks for would make the steady one wider at each exchange than its own noise does. */
#define LEAST_TAKEN 0.01
/* No model's probability is made smaller than this share of itself by one measurement. */
#define LEAST_PROBABILITY 1e-6

#define LANES 8

/* All that is known of n objects: filters (1 + models, FACTORS, n), shares of the models (models, n), derivatives
   (1 + models, UNSEEN, STATE, n), and (n,) the time since the models exchanged their states. */
typedef struct {
    double *filters, *share, *unseen, *apart;
    int64_t models, n;
} Tables;

#define TABLES "out f8[hypotheses,14,n] filters, out f8[models,n] share, out f8[hypotheses,4,4,n] unseen, out f8[n] apart"

static inline Tables tables_of(const Argument *arguments)
{
    return (Tables){ARRAY(double, 0), ARRAY(double, 1), ARRAY(double, 2), ARRAY(double, 3),
                    smaller_i(SIZE(1, 0), SIZE(0, 0) - 1), SIZE(0, 2)};
}

static inline Column filter_of(const Tables *tables, int64_t h, int64_t i)
{
    return column_of(tables->filters + h * FACTORS * tables->n, tables->n, i);
}

static inline Column unseen_of(const Tables *tables, int64_t h, int64_t i)
{
    return column_of(tables->unseen + h * UNSEEN * STATE * tables->n, tables->n, i);
}

/* ---------------------------------------------------------------- new objects, and what is reported of all */

/* Sets the last k objects. */
KERNEL(imm_start, TABLES ", f8[2,k] position, f8[2,k] variance, f8[k] covariance_ne, f8[4,2,k] sensitivity, "
                         "f8[models] usual, float velocity_variance")
{
    const Tables tables = tables_of(arguments);
    const int64_t count = SIZE(6, 0);
    const double *position = ARRAY(const double, 4), *variance = ARRAY(const double, 5);
    const double *covariance_ne = ARRAY(const double, 6), *sensitivity = ARRAY(const double, 7);
    const double *usual = ARRAY(const double, 8);
    if (count > tables.n)
        return;
    for (int64_t k = 0; k < count; k++) {
        const int64_t i = tables.n - count + k;
        const Place place = {position[k], position[count + k], variance[k], variance[count + k], covariance_ne[k]};
        tables.apart[i] = fmod(GOLDEN * (double)i, EXCHANGE_S);
        for (int64_t m = 0; m < tables.models; m++)
            tables.share[m * tables.n + i] = usual[m];
        for (int64_t h = 0; h <= tables.models; h++) {
            const Column unseen = unseen_of(&tables, h, i);
            ud_start(filter_of(&tables, h, i), place, h == RESTING ? 0.0 : FLOAT(9));
            for (int c = 0; c < UNSEEN; c++)
                for (int axis = 0; axis < 2; axis++)
                    BY(unseen, c, axis) = sensitivity[(2 * c + axis) * count + k];
        }
    }
}

/* Carries all filters on over `dt` seconds; noise at rest and of each model, standard deviation of a climb. */
KERNEL(imm_predict, "out f8[hypotheses,14,n] filters, out f8[hypotheses,4,4,n] unseen, float dt, float static_noise, "
                    "f8[models] noise, float climb")
{
    double *filters = ARRAY(double, 0), *unseen = ARRAY(double, 1);
    const double dt = FLOAT(2), *noise = ARRAY(const double, 4);
    const int64_t n = SIZE(0, 2), models = smaller_i(SIZE(4, 0), SIZE(0, 0) - 1);
    if (dt == 0.0)
        return;
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++)
        ud_drift(column_of(filters, n, i), FLOAT(3) * dt);
    for (int64_t h = 1; h <= models; h++) {
        double *filter = filters + h * FACTORS * n;
#pragma GCC ivdep
        for (int64_t i = 0; i < n; i++)
            ud_predict(column_of(filter, n, i), dt, noise[h - 1]);
        carry_on(unseen + h * UNSEEN * STATE * n, n, dt, FLOAT(5));
    }
}

/* Fills position, variance and covariance of `HorizontalState`. */
KERNEL(imm_places, "f8[hypotheses,14,n] filters, out f8[hypotheses,2,n] position, out f8[hypotheses,2,n] variance, "
                   "out f8[hypotheses,n] covariance_ne")
{
    const int64_t hypotheses = SIZE(0, 0), n = SIZE(0, 2);
    for (int64_t h = 0; h < hypotheses; h++) {
        double *filter = ARRAY(double, 0) + h * FACTORS * n, *position = ARRAY(double, 1) + 2 * h * n;
        double *variance = ARRAY(double, 2) + 2 * h * n, *covariance_ne = ARRAY(double, 3) + h * n;
#pragma GCC ivdep
        for (int64_t i = 0; i < n; i++) {
            const Place place = place_of(column_of(filter, n, i));
            position[i] = place.north, position[n + i] = place.east;
            variance[i] = place.variance_north, variance[n + i] = place.variance_east;
            covariance_ne[i] = place.covariance_ne;
        }
    }
}

/* Fills (2, 2, n) mean and variance of the velocities of the moving hypotheses taken together. */
KERNEL(imm_velocity, "f8[hypotheses,14,n] filters, f8[models,n] share, out f8[2,2,n] moments")
{
    const int64_t n = SIZE(0, 2), models = smaller_i(SIZE(1, 0), SIZE(0, 0) - 1);
    const double *share = ARRAY(const double, 1);
    double *filters = ARRAY(double, 0), *mean = ARRAY(double, 2), *variance = mean + 2 * n;
    for (int axis = 0; axis < 2; axis++)
        mixture(share, filters + (FACTORS + VELOCITY + axis) * n, FACTORS * n, models, n, mean + axis * n);
    memset(variance, 0, (size_t)(2 * n) * sizeof *variance);
    for (int64_t m = 0; m < models; m++) {
#pragma GCC ivdep
        for (int64_t i = 0; i < n; i++) {
            const Column s = column_of(filters + (1 + m) * FACTORS * n, n, i);
            const Two own = velocity_variances(s);
            variance[i] += share[m * n + i] * (own.north + square(AT(s, VELOCITY) - mean[i]));
            variance[n + i] += share[m * n + i] * (own.east + square(AT(s, VELOCITY + 1) - mean[n + i]));
        }
    }
}

/* ---------------------------------------------------------------- several objects at a time */

/* One hypothesis of LANES objects. */
typedef struct {
    double filter[FACTORS][LANES], unseen[UNSEEN * STATE][LANES];
} Lanes;

static void gather(const double *table, int64_t rows, int64_t n, const int64_t *who, double (*restrict lanes)[LANES])
{
    for (int64_t row = 0; row < rows; row++)
        for (int l = 0; l < LANES; l++)
            lanes[row][l] = table[row * n + who[l]];
}

/* The last lane first: of an object that is there several times, what was done to its first lane counts. */
static void scatter(double *table, int64_t rows, int64_t n, const int64_t *who, double (*restrict lanes)[LANES])
{
    for (int64_t row = 0; row < rows; row++)
        for (int l = LANES - 1; l >= 0; l--)
            table[row * n + who[l]] = lanes[row][l];
}

static void gather_hypotheses(const Tables *tables, int64_t first, const int64_t *who, Lanes *lanes)
{
    for (int64_t h = first; h <= tables->models; h++) {
        gather(filter_of(tables, h, 0).at, FACTORS, tables->n, who, lanes[h].filter);
        gather(unseen_of(tables, h, 0).at, UNSEEN * STATE, tables->n, who, lanes[h].unseen);
    }
}

static void scatter_hypotheses(const Tables *tables, int64_t first, const int64_t *who, Lanes *lanes)
{
    for (int64_t h = first; h <= tables->models; h++) {
        scatter(filter_of(tables, h, 0).at, FACTORS, tables->n, who, lanes[h].filter);
        scatter(unseen_of(tables, h, 0).at, UNSEEN * STATE, tables->n, who, lanes[h].unseen);
    }
}

/* Fills `who` with LANES of `rows` from k on, the last one again where there are no more; returns how many there are. */
static int64_t next_lanes(const int64_t *rows, int64_t count, int64_t k, int64_t who[LANES])
{
    for (int l = 0; l < LANES; l++)
        who[l] = rows[smaller_i(k + l, count - 1)];
    return smaller_i(count - k, LANES);
}

/* ---------------------------------------------------------------- models exchange their states */

/* Scratch of `exchange`. */
typedef struct {
    Lanes *old, *now;                   /* (1 + models,) hypotheses before and after */
    double (*before)[LANES];            /* (models,) shares of the models before, */
    double (*after)[LANES];             /* (models,) and after */
    double (*came)[LANES];              /* (models,) of a model after: what came from each */
    double (*column[STATE])[LANES];     /* a covariance as the sum of weight[c] column[:][c] column[:][c]', */
    double (*weight)[LANES];            /* ((1 + STATE) models,) */
    int64_t models;
} Work;

static Work work_for(int64_t models)
{
    typedef double Row[LANES];
    const int64_t columns = (1 + STATE) * models;
    Work work = {SCRATCH(Lanes, models + 1), SCRATCH(Lanes, models + 1), SCRATCH(Row, models), SCRATCH(Row, models),
                 SCRATCH(Row, models), {NULL}, SCRATCH(Row, columns), models};
    for (int row = 0; row < STATE; row++)
        work.column[row] = SCRATCH(Row, columns);
    return work;
}

/* Finds what each model gives to model `to`, and its share after; `stay`: with that probability an object goes on as
   before, else as `usual`. */
static void shares_to(Work *work, int64_t to, const double *usual, const double *restrict stay)
{
    double taken[LANES] = {0.0};
    for (int l = 0; l < LANES; l++)
        work->after[to][l] = stay[l] * work->before[to][l] + (1.0 - stay[l]) * usual[to];
    for (int64_t m = 0; m < work->models; m++)
        for (int l = 0; l < LANES; l++) {
            const double into = (1.0 - stay[l]) * usual[to] + (m == to ? stay[l] : 0.0);
            const double came = work->before[m][l] * into / work->after[to][l];
            work->came[m][l] = came >= LEAST_TAKEN ? came : 0.0;
            taken[l] += work->came[m][l];
        }
    for (int64_t m = 0; m < work->models; m++)
        for (int l = 0; l < LANES; l++)
            work->came[m][l] /= taken[l];
}

/* Fills `mean` with the mean of so many rows, which begin `offset` numbers into each hypothesis of before. */
static void mix_rows(const Work *work, size_t offset, int rows, double (*restrict mean)[LANES])
{
    memset(mean, 0, (size_t)rows * sizeof *mean);
    for (int64_t m = 0; m < work->models; m++) {
        const double *old = (const double *)((const char *)&work->old[1 + m] + offset);
        for (int row = 0; row < rows; row++)
            for (int l = 0; l < LANES; l++)
                mean[row][l] += work->came[m][l] * old[row * LANES + l];
    }
}

/* Writes the mixture's covariance as columns: how far the models are from the mean, then L of all of them column by
   column. Row 0 has entries in the first 2 models of them, each further row in `models` more: all else is 0, and left
   out. */
static void fill_columns(Work *work, const Lanes *now)
{
    static const int row_of_l[STATE][STATE] = {{0}, {L10}, {L20, L21}, {L30, L31, L32}};
    const int64_t models = work->models;
    for (int64_t m = 0; m < models; m++) {
        const Lanes *old = &work->old[1 + m];
        for (int row = 0; row < STATE; row++)
            for (int l = 0; l < LANES; l++)
                work->column[row][m][l] = old->filter[row][l] - now->filter[row][l];
        memcpy(work->weight[m], work->came[m], sizeof work->weight[m]);
        for (int column = 0; column < STATE; column++) {
            const int64_t to = models * (1 + column) + m;
            for (int l = 0; l < LANES; l++)
                work->weight[to][l] = work->came[m][l] * old->filter[DIAGONAL + column][l];
            for (int row = 0; row < STATE; row++)
                for (int l = 0; l < LANES; l++)
                    work->column[row][to][l] = row < column ? 0.0 : row == column ? 1.0 : old->filter[row_of_l[row][column]][l];
        }
    }
}

/* Finds the factors of the sum of columns; spoils them. */
static void triangular(Work *work, Lanes *now)
{
    static const int first_of_l[STATE + 1] = {0, L10, L20, L30, FACTORS};
    for (int row = 0; row < STATE; row++) {
        const int64_t count = work->models * (2 + row);
        double square[LANES] = {0.0}, inverse[LANES];
        for (int64_t c = 0; c < count; c++)
            for (int l = 0; l < LANES; l++)
                square[l] += work->weight[c][l] * work->column[row][c][l] * work->column[row][c][l];
        for (int l = 0; l < LANES; l++)
            inverse[l] = one_by(square[l]);
        memcpy(now->filter[DIAGONAL + row], square, sizeof square);
        for (int below = row + 1; below < STATE; below++) {
            double slope[LANES] = {0.0};
            for (int64_t c = 0; c < count; c++)
                for (int l = 0; l < LANES; l++)
                    slope[l] += work->weight[c][l] * work->column[row][c][l] * work->column[below][c][l];
            for (int l = 0; l < LANES; l++)
                slope[l] *= inverse[l];
            for (int64_t c = 0; c < count; c++)
                for (int l = 0; l < LANES; l++)
                    work->column[below][c][l] -= slope[l] * work->column[row][c][l];
            memcpy(now->filter[first_of_l[below] + row], slope, sizeof slope);
        }
    }
}

/* Lets the models of LANES objects exchange their states. */
static void exchange(const Tables *tables, const int64_t *who, const double *usual, double change_rate,
                     Work *work)
{
    double stay[LANES];
    gather_hypotheses(tables, 1, who, work->old);
    gather(tables->share, work->models, tables->n, who, work->before);
    for (int l = 0; l < LANES; l++)
        stay[l] = exp(-change_rate * tables->apart[who[l]]);
    for (int64_t to = 0; to < work->models; to++) {
        Lanes *now = &work->now[1 + to];
        shares_to(work, to, usual, stay);
        mix_rows(work, offsetof(Lanes, filter), STATE, now->filter);
        mix_rows(work, offsetof(Lanes, unseen), UNSEEN * STATE, now->unseen);
        fill_columns(work, now);
        triangular(work, now);
    }
    scatter_hypotheses(tables, 1, who, work->now);
    scatter(tables->share, work->models, tables->n, who, work->after);
    for (int l = 0; l < LANES; l++)
        tables->apart[who[l]] = 0.0;
}

/* Lets the models of those of `rows` exchange their states that did so long ago; `since_s`: time since the last
   measurement. */
static void exchange_where_due(const Tables *tables, const int64_t *rows, const double *since_s, int64_t count,
                               const double *usual, double change_rate)
{
    int64_t due = 0, who[LANES], *list = SCRATCH(int64_t, count);
    for (int64_t k = 0; k < count; k++) {
        tables->apart[rows[k]] += since_s[k];
        if (tables->apart[rows[k]] >= EXCHANGE_S)
            list[due++] = rows[k];
    }
    if (due == 0 || tables->models < 2)
        return;
    Work work = work_for(tables->models);
    for (int64_t k = 0; k < due; k += LANES) {
        next_lanes(list, due, k, who);
        exchange(tables, who, usual, change_rate, &work);
    }
}

/* ---------------------------------------------------------------- measurements */

/* What a measurement is to one hypothesis of LANES objects. */
typedef struct {
    double log_likelihood[LANES], step[LANES], variance[LANES], square[LANES], square_variance[LANES];
} Answer;

/* Changes the states of a filter as the mean height does by `step`. */
static inline void lower(Column s, Column unseen, double step)
{
    double by[STATE];
    lowered(unseen, step, by);
    for (int row = 0; row < STATE; row++)
        AT(s, row) += by[row];
}

/* Corrects one filter, and its derivatives, of `lanes` objects by their measurements from k on; g: at rest or moving. */
static void correct(Lanes *own, const PositionMeasurement *measured, const Heights *heights, int g, int64_t k, int64_t lanes,
                    Answer *answer)
{
    double distance[LANES], determinant[LANES];
#pragma GCC ivdep
    for (int64_t l = 0; l < lanes; l++) {
        const Column s = {&own->filter[0][l], LANES}, unseen = {&own->unseen[0][l], LANES};
        lower(s, unseen, heights->step[g * measured->count + k + l]);
        const Fix fix = fix_of(measured, k + l, heights, g);
        const Place place = place_of(s);
        const Innovation residual = innovation(unseen, &place, &fix);
        const Gain gain =
            ud_update(s, residual.north, residual.east, fix.variance_north, fix.variance_east, fix.covariance_ne);
        correct_unseen(unseen, &gain, &residual, &fix);
        distance[l] = residual.distance, determinant[l] = residual.determinant;
        answer->step[l] = residual.step, answer->variance[l] = residual.variance;
        answer->square[l] = residual.square, answer->square_variance[l] = residual.square_variance;
    }
    clear_upper_halves();
    for (int64_t l = 0; l < lanes; l++)
        answer->log_likelihood[l] = log_likelihood(distance[l], determinant[l]);
}

/* Updates the probabilities of an object's models by their log-likelihoods; returns that of all together. */
static double weigh(const Tables *tables, int64_t i, const Answer *answers, int64_t lane)
{
    double best = answers[0].log_likelihood[lane], total = 0.0;
    for (int64_t m = 1; m < tables->models; m++)
        best = larger(best, answers[m].log_likelihood[lane]);
    for (int64_t m = 0; m < tables->models; m++) {
        double *share = &tables->share[m * tables->n + i];
        *share *= larger(exp(answers[m].log_likelihood[lane] - best), LEAST_PROBABILITY);
        total += *share;
    }
    for (int64_t m = 0; m < tables->models; m++)
        tables->share[m * tables->n + i] /= total;
    return best + log(total);
}

/* Fills mean and variance of what the models say taken together, whose numbers lie `apart` from each other. */
static void together(const Tables *tables, int64_t i, const double *mean, const double *variance, int64_t apart,
                     double *middle, double *spread)
{
    const double *share = tables->share + i;
    *middle = *spread = 0.0;
    for (int64_t m = 0; m < tables->models; m++)
        *middle += share[m * tables->n] * mean[m * apart];
    for (int64_t m = 0; m < tables->models; m++)
        *spread += share[m * tables->n] * (variance[m * apart] + square(mean[m * apart] - *middle));
}

/* Takes the answers of the hypotheses of object i together as what measurement k says. */
static void learn(const Tables *tables, int64_t i, const Answer *answers, int64_t lane, const Learned *learned, int64_t k,
                  int64_t count)
{
    const int64_t moving = count + k, apart = sizeof(Answer) / sizeof(double);
    const Answer *rest = &answers[RESTING], *models = &answers[1];
    learned->log_likelihood[k] = rest->log_likelihood[lane];
    learned->step[k] = rest->step[lane], learned->variance[k] = rest->variance[lane];
    learned->square[k] = rest->square[lane], learned->square_variance[k] = rest->square_variance[lane];
    learned->log_likelihood[moving] = weigh(tables, i, models, lane);
    together(tables, i, &models->step[lane], &models->variance[lane], apart, &learned->step[moving],
             &learned->variance[moving]);
    together(tables, i, &models->square[lane], &models->square_variance[lane], apart, &learned->square[moving],
             &learned->square_variance[moving]);
}

/* Changes the states of a hypothesis of `lanes` objects as what was learned changes their heights. */
static void lower_all(Lanes *own, const double *step, int64_t lanes)
{
#pragma GCC ivdep
    for (int64_t l = 0; l < lanes; l++)
        lower((Column){&own->filter[0][l], LANES}, (Column){&own->unseen[0][l], LANES}, step[l]);
}

/* Updates all filters of `rows` by a measurement each, and fills the (5, 2, k) table of `Learned`. */
KERNEL(imm_update, TABLES ", i8[k] rows, " POSITION_MEASUREMENT ", f8[k] since_s, f8[models] usual, float change_rate, "
                          "f8[5,2,k] heights, out f8[5,2,k] learned")
{
    const Tables tables = tables_of(arguments);
    const int64_t count = SIZE(4, 0), *rows = ARRAY(const int64_t, 4);
    const PositionMeasurement measured = position_measurement_from(arguments, 5);
    const Heights heights = height_rows(ARRAY(double, 20), count);
    const Learned learned = learned_rows(ARRAY(double, 21), count);
    Lanes *lanes = SCRATCH(Lanes, tables.models + 1);
    Answer *answers = SCRATCH(Answer, tables.models + 1);
    int64_t who[LANES];
    if (!all_inside(rows, count, tables.n) || tables.models < 1)
        return;
    exchange_where_due(&tables, rows, ARRAY(const double, 17), count, ARRAY(const double, 18), FLOAT(19));
    for (int64_t k = 0; k < count; k += LANES) {
        const int64_t found = next_lanes(rows, count, k, who);
        gather_hypotheses(&tables, RESTING, who, lanes);
        for (int64_t h = 0; h <= tables.models; h++)
            correct(&lanes[h], &measured, &heights, h == RESTING ? 0 : 1, k, found, &answers[h]);
        for (int64_t l = 0; l < found; l++)
            learn(&tables, who[l], answers, l, &learned, k + l, count);
        for (int64_t h = 0; h <= tables.models; h++)
            lower_all(&lanes[h], learned.step + (h == RESTING ? 0 : count) + k, found);
        scatter_hypotheses(&tables, RESTING, who, lanes);
    }
}

/* ---------------------------------------------------------------- hypotheses that start anew */

/* Starts the static hypothesis of `rows` anew where the likeliest of the moving ones is now. */
KERNEL(imm_rest_there, TABLES ", i8[k] rows")
{
    const Tables tables = tables_of(arguments);
    const int64_t count = SIZE(4, 0), n = tables.n, *rows = ARRAY(const int64_t, 4);
    if (!all_inside(rows, count, n) || tables.models < 1)
        return;
    for (int64_t k = 0; k < count; k++) {
        const int64_t i = rows[k];
        int64_t likeliest = 0;
        for (int64_t m = 1; m < tables.models; m++)
            if (tables.share[m * n + i] > tables.share[likeliest * n + i])
                likeliest = m;
        const Column rest = unseen_of(&tables, RESTING, i), moving = unseen_of(&tables, 1 + likeliest, i);
        ud_start(filter_of(&tables, RESTING, i), place_of(filter_of(&tables, 1 + likeliest, i)), 0.0);
        for (int c = 0; c < UNSEEN; c++)
            for (int axis = 0; axis < 2; axis++)
                BY(rest, c, axis) = BY(moving, c, axis);
    }
}

/* Starts the moving hypotheses of `rows` anew where the static one is, with unknown velocity, as likely as `usual`. */
KERNEL(imm_set_out, TABLES ", i8[k] rows, f8[models] usual, float velocity_variance")
{
    const Tables tables = tables_of(arguments);
    const int64_t count = SIZE(4, 0), n = tables.n, *rows = ARRAY(const int64_t, 4);
    if (!all_inside(rows, count, n))
        return;
    for (int64_t k = 0; k < count; k++)
        for (int64_t h = 1; h <= tables.models; h++) {
            const int64_t i = rows[k];
            const Column moving = unseen_of(&tables, h, i), rest = unseen_of(&tables, RESTING, i);
            tables.share[(h - 1) * n + i] = ARRAY(const double, 5)[h - 1];
            ud_start(filter_of(&tables, h, i), place_of(filter_of(&tables, RESTING, i)), FLOAT(6));
            for (int row = 0; row < UNSEEN * STATE; row++)
                AT(moving, row) = AT(rest, row);
        }
}

/* Lets the static hypotheses of `heirs` learn where those of `old`, the same objects, were. */
KERNEL(imm_join, TABLES ", i8[k] heirs, i8[k] old")
{
    const Tables tables = tables_of(arguments);
    const int64_t count = SIZE(4, 0), *heirs = ARRAY(const int64_t, 4), *old = ARRAY(const int64_t, 5);
    if (!all_inside(heirs, count, tables.n) || !all_inside(old, count, tables.n))
        return;
    for (int64_t k = 0; k < count; k++) {
        const Column s = filter_of(&tables, RESTING, heirs[k]), own = unseen_of(&tables, RESTING, heirs[k]);
        const Column before = unseen_of(&tables, RESTING, old[k]);
        const Place place = place_of(filter_of(&tables, RESTING, old[k]));
        const Gain gain = ud_update(s, place.north - AT(s, NORTH), place.east - AT(s, EAST), place.variance_north,
                                    place.variance_east, place.covariance_ne);
        for (int c = 0; c < UNSEEN; c++) {
            const double north = BY(before, c, NORTH) - BY(own, c, NORTH), east = BY(before, c, EAST) - BY(own, c, EAST);
            BY(own, c, NORTH) += gain.north[NORTH] * north + gain.east[NORTH] * east;
            BY(own, c, EAST) += gain.north[EAST] * north + gain.east[EAST] * east;
        }
    }
}
