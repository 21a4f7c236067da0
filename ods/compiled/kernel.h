/* What every kernel includes: how it is declared, what it is called with, and memory for the time of the call.

   A kernel is a loop over arrays that numpy would take too many passes for. It computes; it knows nothing of Python.
   KERNEL names it, and says in one string what it takes (binding.c checks each call against it):

       KERNEL(blend, "f4[beams,samples] image, float share, out f4[beams,samples] mean")
       {
           const float *image = ARRAY(float, 0);
           const double share = FLOAT(1);
           float *mean = ARRAY(float, 2);
           for (int64_t k = 0; k < SIZE(0, 0) * SIZE(0, 1); k++)
               mean[k] += (float)share * (image[k] - mean[k]);
       }

   Arguments, separated by commas:
     TYPE[DIMENSIONS] NAME   an array, C-contiguous; `out` before it: it is written to.
         TYPE         b1 (bool), u1, u2, u4, i4, i8, f4, f8, or rN: records of N bytes; u1|u2|f4: one of these, TYPE(k) says which
         DIMENSIONS   a name (equal names must have equal sizes in one call), a number (that size), or `:` (any)
         `rows` before the type: rows may lie apart (STRIDE elements from one to the next); each is contiguous
     int NAME, float NAME, bool NAME   a number
   Python may pass a tuple (a NamedTuple) for several arguments in turn. */

#ifndef ODS_KERNEL_H
#define ODS_KERNEL_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define MOST_DIMENSIONS 4

/* One argument of a call. */
typedef struct {
    void *data;
    int64_t shape[MOST_DIMENSIONS];
    int64_t stride; /* elements from one row to the next, of an array of two dimensions */
    int64_t integer;
    double number;
    char type; /* as numpy's typecode: ? B H I i l f d V */
} Argument;

typedef union {
    int64_t integer;
    double number;
} Returned;

typedef struct {
    const char *name;
    const char *signature;
    Returned (*run)(const Argument *arguments);
    char returns; /* 0: nothing, i: an int, f: a float, b: a bool */
    char frees_gil;
} Kernel;

#define ARRAY(TYPE, k) ((TYPE *)arguments[k].data)
#define SIZE(k, axis) (arguments[k].shape[axis])
#define STRIDE(k) (arguments[k].stride)
#define TYPE(k) (arguments[k].type)
#define INT(k) (arguments[k].integer)
#define FLOAT(k) (arguments[k].number)
#define BOOL(k) (arguments[k].integer != 0)

/* Returns how many arguments a signature, or a part of one, names. */
static inline int64_t arguments_of(const char *signature)
{
    int64_t count = 1, brackets = 0;
    for (const char *text = signature; *text != 0; text++) {
        brackets += (*text == '[') - (*text == ']');
        count += *text == ',' && brackets == 0;
    }
    return count;
}

/* The linker gathers all of them in one table, which binding.c reads. */
#define ODS_KERNEL(name, signature, returns, field, ctype, frees_gil)                                                   \
    static ctype name(const Argument *arguments);                                                                      \
    static Returned run_##name(const Argument *arguments) { return (Returned){.field = name(arguments)}; }              \
    ODS_ENTRY(name, signature, returns, frees_gil)                                                                     \
    static ctype name(const Argument *arguments)
#define ODS_ENTRY(name, signature, returns, frees_gil)                                                                  \
    static const Kernel kernel_##name = {#name, signature, run_##name, returns, frees_gil};                             \
    static const Kernel *const entry_##name __attribute__((used, section("ods_kernels"))) = &kernel_##name;
#define ODS_VOID_KERNEL(name, signature, frees_gil)                                                                     \
    static void name(const Argument *arguments);                                                                       \
    static Returned run_##name(const Argument *arguments) { return name(arguments), (Returned){0}; }                    \
    ODS_ENTRY(name, signature, 0, frees_gil)                                                                           \
    static void name(const Argument *arguments)

#define KERNEL(name, signature) ODS_VOID_KERNEL(name, signature, 0)
#define KERNEL_INT(name, signature) ODS_KERNEL(name, signature, 'i', integer, int64_t, 0)
#define KERNEL_FLOAT(name, signature) ODS_KERNEL(name, signature, 'f', number, double, 0)
#define KERNEL_BOOL(name, signature) ODS_KERNEL(name, signature, 'b', integer, bool, 0)
/* The same for work of milliseconds: other Python threads run meanwhile. */
#define LONG_KERNEL(name, signature) ODS_VOID_KERNEL(name, signature, 1)
#define LONG_KERNEL_INT(name, signature) ODS_KERNEL(name, signature, 'i', integer, int64_t, 1)
#define LONG_KERNEL_FLOAT(name, signature) ODS_KERNEL(name, signature, 'f', number, double, 1)

#define PI 3.14159265358979323846
/* Keeps quotients and logarithms finite. */
#define NOT_ZERO 1e-300

/* Returns memory for `count` elements until the kernel returns; not cleared. Aligned to 64 bytes. */
#define SCRATCH(TYPE, count) ((TYPE *)ods_scratch((size_t)(count) * sizeof(TYPE)))
/* The same, all zero. */
#define ZEROS(TYPE, count) ((TYPE *)memset(ods_scratch((size_t)(count) * sizeof(TYPE)), 0, (size_t)(count) * sizeof(TYPE)))
void *ods_scratch(size_t bytes);

/* Ends what wide vectors left in the upper halves of registers, which slows each call of libm down until then (20 times
   where it was measured). gcc does so by itself, but not on all ways out of a function. */
static inline void clear_upper_halves(void)
{
#ifdef __AVX__
    __builtin_ia32_vzeroupper();
#endif
}

static inline double larger(double a, double b) { return a > b ? a : b; }
static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline float larger_f(float a, float b) { return a > b ? a : b; }
static inline float smaller_f(float a, float b) { return a < b ? a : b; }
static inline int64_t larger_i(int64_t a, int64_t b) { return a > b ? a : b; }
static inline int64_t smaller_i(int64_t a, int64_t b) { return a < b ? a : b; }
static inline double square(double x) { return x * x; }

#endif
