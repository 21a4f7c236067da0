/* Who gets what, so that the sum of costs is the least possible: linear assignment by shortest augmenting paths.

   R. Jonker, A. Volgenant: A shortest augmenting path algorithm for dense and sparse linear assignment problems,
   Computing 38, 1987; for rectangular matrices as in D. F. Crouse: On implementing 2D rectangular assignment algorithms,
   IEEE Trans. Aerospace and Electronic Systems 52, 2016. */

#include "kernel.h"

/* Sums are left in order: of equally good assignments the same one is found on every machine. */
#pragma GCC optimize("no-associative-math")

enum { NONE = -1 };

/* What is assigned so far, and the dual variables that prove it the best. */
typedef struct {
    const double *cost; /* (rows, columns) */
    int64_t rows, columns;
    int64_t *column_of; /* (rows,), NONE: none */
    int64_t *row_of;    /* (columns,), NONE: none */
    double *row_dual, *column_dual;
} State;

/* Shortest paths of one search from a row without a column. */
typedef struct {
    double *length;  /* (columns,) to each column */
    int64_t *before; /* (columns,) row before each column */
    int64_t *order;  /* (columns,) those not reached yet, then those reached */
} Paths;

/* Makes the paths to the first `left` columns of the order shorter, where they are by `row`, which is `shortest` away;
   returns the nearest one's place in the order, NONE where all are infinitely far. */
static int64_t nearest_by(int64_t row, double shortest, int64_t left, State state, Paths paths)
{
    const double *cost = state.cost + row * state.columns, dual = state.row_dual[row];
    int64_t nearest = NONE;
    double least = INFINITY;
    for (int64_t place = 0; place < left; place++) {
        const int64_t column = paths.order[place];
        const double found = shortest + cost[column] - dual - state.column_dual[column];
        if (found < paths.length[column]) {
            paths.length[column] = found;
            paths.before[column] = row;
        }
        const double length = paths.length[column];
        if (length < least || (length == least && state.row_of[column] == NONE)) {
            nearest = place;
            least = length;
        }
    }
    return least < INFINITY ? nearest : NONE;
}

/* Reaches columns from row `start` until one is free; returns the place in the order from which on they were reached,
   the last one, the free one, first; NONE where a row has no gain that is a finite number. */
static int64_t search(int64_t start, State state, Paths paths)
{
    for (int64_t column = 0; column < state.columns; column++) {
        paths.length[column] = INFINITY;
        paths.order[column] = state.columns - 1 - column;
    }
    int64_t row = start;
    double shortest = 0.0;
    for (int64_t left = state.columns; left > 0; left--) {
        const int64_t nearest = nearest_by(row, shortest, left, state, paths);
        if (nearest == NONE)
            return NONE;
        const int64_t column = paths.order[nearest];
        shortest = paths.length[column];
        paths.order[nearest] = paths.order[left - 1];
        paths.order[left - 1] = column;
        row = state.row_of[column];
        if (row == NONE)
            return left - 1;
    }
    return NONE;
}

static void update_duals(int64_t start, int64_t reached, State state, Paths paths)
{
    const double shortest = paths.length[paths.order[reached]];
    state.row_dual[start] += shortest;
    for (int64_t place = reached + 1; place < state.columns; place++) {
        const int64_t column = paths.order[place];
        state.column_dual[column] -= shortest - paths.length[column];
        state.row_dual[state.row_of[column]] += shortest - paths.length[column];
    }
}

/* Gives each row of the path from row `start` to the free `column` the column behind it. */
static void augment(int64_t start, int64_t column, State state, Paths paths)
{
    for (int64_t row = NONE; row != start;) {
        row = paths.before[column];
        state.row_of[column] = row;
        const int64_t own = state.column_of[row];
        state.column_of[row] = column;
        column = own;
    }
}

/* Sets the column of each row that makes the sum of costs the least; returns whether it could: there must be as many
   columns as rows, and in each row a cost that is a finite number. */
KERNEL_BOOL(assign_columns, "f8[rows,columns] cost, out i8[rows] column_of")
{
    const int64_t rows = SIZE(0, 0), columns = SIZE(0, 1);
    const State state = {
        .cost = ARRAY(double, 0),
        .rows = rows,
        .columns = columns,
        .column_of = ARRAY(int64_t, 1),
        .row_of = SCRATCH(int64_t, columns),
        .row_dual = ZEROS(double, rows),
        .column_dual = ZEROS(double, columns),
    };
    const Paths paths = {SCRATCH(double, columns), SCRATCH(int64_t, columns), SCRATCH(int64_t, columns)};
    for (int64_t row = 0; row < rows; row++)
        state.column_of[row] = NONE;
    for (int64_t column = 0; column < columns; column++)
        state.row_of[column] = NONE;
    for (int64_t start = 0; start < rows; start++) {
        const int64_t reached = search(start, state, paths);
        if (reached == NONE)
            return false;
        update_duals(start, reached, state, paths);
        augment(start, paths.order[reached], state, paths);
    }
    return true;
}
