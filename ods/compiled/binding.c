/* The Python module of all kernels: checks the arguments of each call against the kernel's signature (kernel.h). */

#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#define NPY_TARGET_VERSION NPY_2_0_API_VERSION
#include <numpy/arrayobject.h>

#include "kernel.h"

#define MOST_ARGUMENTS 64
#define MOST_NAMES 32
#define MOST_TYPES 8

/* One argument of a signature. */
typedef struct {
    char types[MOST_TYPES]; /* numpy's typecodes, 0 after the last; for numbers: int 'n', float 'x', bool 'y' */
    char is_array, is_written, has_apart_rows;
    int record_bytes, dimensions;
    int names[MOST_DIMENSIONS];        /* which name of a size each dimension has; -1: none */
    int64_t sizes[MOST_DIMENSIONS];    /* a size that is given as a number; -1: none */
    char name[48];
} Parameter;

typedef struct {
    const Kernel *kernel;
    int count;
    Parameter parameters[MOST_ARGUMENTS];
} Signature;

/* ---------------------------------------------------------------- memory for the time of a call */

/* `make sanitize` sets it to 0: each scratch array is then a block of its own, and a sanitizer sees what runs over it. */
#ifndef KEPT_BYTES
#define KEPT_BYTES ((size_t)1 << 22)
#endif

typedef struct Block {
    struct Block *before;
    size_t used, size;
    char *start;
} Block;

static _Thread_local Block *newest;

static Block *new_block(size_t size, Block *before)
{
    Block *block = malloc(sizeof *block);
    void *start;
    if (block == NULL || posix_memalign(&start, 64, size) != 0)
        Py_FatalError("out of memory in a kernel");
    *block = (Block){before, 0, size, start};
    return block;
}

void *ods_scratch(size_t bytes)
{
    if (KEPT_BYTES != 0)
        bytes = (bytes + 63) & ~(size_t)63;
    if (newest == NULL || newest->size - newest->used < bytes)
        newest = new_block(bytes > KEPT_BYTES / 4 ? bytes : KEPT_BYTES / 4, newest);
    void *found = newest->start + newest->used;
    newest->used += bytes;
    return found;
}

/* Leaves one block, not a large one, for the next call. */
static void free_scratch(void)
{
    while (newest != NULL && (newest->before != NULL || newest->size > KEPT_BYTES)) {
        Block *before = newest->before;
        free(newest->start);
        free(newest);
        newest = before;
    }
    if (newest != NULL)
        newest->used = 0;
}

/* ---------------------------------------------------------------- signatures */

static const struct {
    const char *name;
    char code;
} TYPES[] = {{"b1", '?'}, {"u1", 'B'}, {"u2", 'H'}, {"u4", 'I'}, {"i4", 'i'}, {"i8", 'l'}, {"f4", 'f'}, {"f8", 'd'},
             {"int", 'n'}, {"float", 'x'}, {"bool", 'y'}};

static const char *skip(const char *text)
{
    while (*text == ' ' || *text == '\n')
        text++;
    return text;
}

/* Copies a word of letters, digits and _ and returns what follows it. */
static const char *take_word(const char *text, char *word, size_t size)
{
    size_t k = 0;
    text = skip(text);
    while ((*text >= 'a' && *text <= 'z') || (*text >= 'A' && *text <= 'Z') || (*text >= '0' && *text <= '9') || *text == '_') {
        if (k + 1 < size)
            word[k++] = *text;
        text++;
    }
    word[k] = 0;
    return skip(text);
}

static char code_of(const char *word, Parameter *parameter)
{
    for (size_t k = 0; k < sizeof TYPES / sizeof *TYPES; k++)
        if (strcmp(word, TYPES[k].name) == 0)
            return TYPES[k].code;
    if (word[0] == 'r' && word[1] >= '0' && word[1] <= '9') {
        parameter->record_bytes = atoi(word + 1);
        return 'V';
    }
    return 0;
}

static int number_of(const char *word, char (*names)[24], int *count)
{
    for (int k = 0; k < *count; k++)
        if (strcmp(names[k], word) == 0)
            return k;
    if (*count == MOST_NAMES)
        return -2;
    memcpy(names[*count], word, 24);
    return (*count)++;
}

static const char *parse_dimensions(const char *text, Parameter *parameter, char (*names)[24], int *count)
{
    do {
        char word[24];
        int axis = parameter->dimensions;
        if (axis == MOST_DIMENSIONS)
            return NULL;
        text = take_word(text + 1, word, sizeof word);
        parameter->names[axis] = parameter->sizes[axis] = -1;
        if (*text == ':')
            text = skip(text + 1);
        else if (word[0] >= '0' && word[0] <= '9')
            parameter->sizes[axis] = atoi(word);
        else if ((parameter->names[axis] = number_of(word, names, count)) < 0 || word[0] == 0)
            return NULL;
        parameter->dimensions++;
    } while (*text == ',');
    return *text == ']' ? skip(text + 1) : NULL;
}

static int parse(const Kernel *kernel, Signature *signature)
{
    char names[MOST_NAMES][24], word[48];
    int count = 0;
    const char *text = skip(kernel->signature);
    signature->kernel = kernel;
    while (*text != 0) {
        Parameter *parameter = &signature->parameters[signature->count];
        int types = 0;
        if (signature->count++ == MOST_ARGUMENTS)
            return -1;
        memset(parameter, 0, sizeof *parameter);
        text = take_word(text, word, sizeof word);
        for (; strcmp(word, "out") == 0 || strcmp(word, "rows") == 0; text = take_word(text, word, sizeof word)) {
            parameter->is_written |= word[0] == 'o';
            parameter->has_apart_rows |= word[0] == 'r';
        }
        for (;; text = take_word(text + 1, word, sizeof word)) {
            if (types == MOST_TYPES - 1 || (parameter->types[types++] = code_of(word, parameter)) == 0)
                return -1;
            if (*text != '|')
                break;
        }
        parameter->is_array = strchr("nxy", parameter->types[0]) == NULL;
        if (parameter->is_array && (*text != '[' || (text = parse_dimensions(text, parameter, names, &count)) == NULL))
            return -1;
        text = take_word(text, parameter->name, sizeof parameter->name);
        if (parameter->name[0] == 0 || (*text != ',' && *text != 0))
            return -1;
        text = skip(*text == ',' ? text + 1 : text);
    }
    return 0;
}

/* ---------------------------------------------------------------- calls */

static int refuse(const Signature *signature, const Parameter *parameter, const char *why)
{
    PyErr_Format(PyExc_TypeError, "%s: %s %s (%s)", signature->kernel->name, parameter->name, why, signature->kernel->signature);
    return -1;
}

static int check_type(const Parameter *parameter, PyArrayObject *array, char *type)
{
    char code = PyArray_DESCR(array)->type;
    if (code == 'q')
        code = 'l';
    *type = code;
    if (strchr(parameter->types, code) == NULL || !PyArray_ISNBO(PyArray_DESCR(array)->byteorder))
        return -1;
    return code == 'V' && PyArray_ITEMSIZE(array) != parameter->record_bytes ? -1 : 0;
}

static int take_array(const Signature *signature, const Parameter *parameter, PyObject *value, Argument *argument, int64_t *sizes)
{
    if (!PyArray_Check(value))
        return refuse(signature, parameter, "must be an array");
    PyArrayObject *array = (PyArrayObject *)value;
    const int dimensions = PyArray_NDIM(array);
    if (check_type(parameter, array, &argument->type) < 0)
        return refuse(signature, parameter, "has another type of elements");
    if (dimensions != parameter->dimensions)
        return refuse(signature, parameter, "has another number of dimensions");
    argument->data = PyArray_DATA(array);
    for (int axis = 0; axis < dimensions; axis++) {
        const int64_t size = argument->shape[axis] = PyArray_DIM(array, axis);
        const int name = parameter->names[axis];
        if (parameter->sizes[axis] >= 0 ? size != parameter->sizes[axis] : name >= 0 && sizes[name] >= 0 && size != sizes[name])
            return refuse(signature, parameter, "has another size");
        if (name >= 0)
            sizes[name] = size;
    }
    const int64_t bytes = PyArray_ITEMSIZE(array);
    if (parameter->has_apart_rows) {
        const int64_t step = PyArray_STRIDE(array, 0);
        if (dimensions != 2 || (argument->shape[1] > 1 && PyArray_STRIDE(array, 1) != bytes) || step % bytes != 0)
            return refuse(signature, parameter, "has rows that are not contiguous");
        argument->stride = step / bytes;
    } else {
        if (!PyArray_IS_C_CONTIGUOUS(array))
            return refuse(signature, parameter, "is not C-contiguous");
        argument->stride = dimensions > 1 ? argument->shape[dimensions - 1] : 1;
    }
    if (!PyArray_ISALIGNED(array))
        return refuse(signature, parameter, "is not aligned");
    if (parameter->is_written && !PyArray_ISWRITEABLE(array))
        return refuse(signature, parameter, "cannot be written to");
    return 0;
}

static int take_number(const Parameter *parameter, PyObject *value, Argument *argument)
{
    switch (parameter->types[0]) {
    case 'x':
        argument->number = PyFloat_AsDouble(value);
        return argument->number == -1.0 && PyErr_Occurred() ? -1 : 0;
    case 'y':
        argument->integer = PyObject_IsTrue(value);
        return argument->integer < 0 ? -1 : 0;
    default:
        argument->integer = PyLong_AsLongLong(value);
        return argument->integer == -1 && PyErr_Occurred() ? -1 : 0;
    }
}

static int take(const Signature *signature, PyObject *value, int *taken, Argument *arguments, int64_t *sizes)
{
    if (PyTuple_Check(value)) {
        const Py_ssize_t count = PyTuple_Size(value);
        for (Py_ssize_t k = 0; k < count; k++)
            if (take(signature, PyTuple_GetItem(value, k), taken, arguments, sizes) < 0)
                return -1;
        return 0;
    }
    if (*taken == signature->count) {
        PyErr_Format(PyExc_TypeError, "%s: too many arguments (%s)", signature->kernel->name, signature->kernel->signature);
        return -1;
    }
    const Parameter *parameter = &signature->parameters[*taken];
    Argument *argument = &arguments[(*taken)++];
    return parameter->is_array ? take_array(signature, parameter, value, argument, sizes)
                               : take_number(parameter, value, argument);
}

static PyObject *call(PyObject *self, PyObject *const *values, Py_ssize_t count)
{
    const Signature *signature = PyCapsule_GetPointer(self, NULL);
    const Kernel *kernel = signature->kernel;
    Argument arguments[MOST_ARGUMENTS];
    int64_t sizes[MOST_NAMES];
    int taken = 0;
    memset(sizes, -1, sizeof sizes);
    for (Py_ssize_t k = 0; k < count; k++)
        if (take(signature, values[k], &taken, arguments, sizes) < 0)
            return NULL;
    if (taken != signature->count) {
        PyErr_Format(PyExc_TypeError, "%s: too few arguments (%s)", kernel->name, kernel->signature);
        return NULL;
    }
    PyThreadState *state = kernel->frees_gil ? PyEval_SaveThread() : NULL;
    const Returned returned = kernel->run(arguments);
    clear_upper_halves();
    free_scratch();
    if (state != NULL)
        PyEval_RestoreThread(state);
    switch (kernel->returns) {
    case 'i':
        return PyLong_FromLongLong(returned.integer);
    case 'f':
        return PyFloat_FromDouble(returned.number);
    case 'b':
        return PyBool_FromLong(returned.integer != 0);
    default:
        Py_RETURN_NONE;
    }
}

/* ---------------------------------------------------------------- module */

extern const Kernel *const __start_ods_kernels[], *const __stop_ods_kernels[];

static int add_kernel(PyObject *module, const Kernel *kernel)
{
    Signature *signature = calloc(1, sizeof *signature);
    PyMethodDef *method = calloc(1, sizeof *method);
    if (signature == NULL || method == NULL) {
        PyErr_NoMemory();
        return -1;
    }
    if (parse(kernel, signature) < 0) {
        PyErr_Format(PyExc_SystemError, "kernel %s: signature not understood: %s", kernel->name, kernel->signature);
        return -1;
    }
    *method = (PyMethodDef){kernel->name, (PyCFunction)(void (*)(void))call, METH_FASTCALL, kernel->signature};
    PyObject *capsule = PyCapsule_New(signature, NULL, NULL);
    PyObject *function = capsule == NULL ? NULL : PyCFunction_NewEx(method, capsule, NULL);
    const int failed = function == NULL || PyObject_SetAttrString(module, kernel->name, function) < 0;
    Py_XDECREF(capsule);
    Py_XDECREF(function);
    return failed ? -1 : 0;
}

static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "native", "All kernels, compiled from C.", -1, NULL, NULL, NULL, NULL, NULL};

static PyObject *make_module(void)
{
    import_array();
    PyObject *module = PyModule_Create(&definition);
    for (const Kernel *const *entry = __start_ods_kernels; module != NULL && entry < __stop_ods_kernels; entry++)
        if (add_kernel(module, *entry) < 0) {
            Py_DECREF(module);
            return NULL;
        }
    return module;
}

/* Runs before any kernel, on whatever processor there is: an unknown instruction would end the process without a word. */
#if defined(__x86_64__)
__attribute__((target("arch=x86-64")))
#endif
PyMODINIT_FUNC PyInit_native(void)
{
#if defined(__AVX2__)
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !__builtin_cpu_supports("bmi2")) {
        PyObject *name = PyUnicode_FromString("ods.compiled.native");
        PyObject *why = PyUnicode_FromString("this processor has no AVX2, which they need: "
                                             "build ODS from its sources on it with ODS_MARCH=native");
        PyErr_SetImportError(why, name, NULL);
        Py_XDECREF(name);
        Py_XDECREF(why);
        return NULL;
    }
#endif
    return make_module();
}
