/* Runs the calls of kernels that kernel_calls.py has written and writes what comes of them: `cross_build CALLS MADE`.

   CALLS: for each call the kernel's name (64 bytes), the number of its arguments, and each of these: type (0: a number), shape,
   stride, integer, number, which argument before it is the same array (or -1), bytes of data: 8 bytes each; then the data.
   MADE: for each call what it returned, 8 bytes, and the data of its arrays. */

#define _POSIX_C_SOURCE 200809L
#include <stdio.h>

#include "kernel.h"

#define MOST_ARGUMENTS 64
#define MOST_BLOCKS 1000000

extern const Kernel *const __start_ods_kernels[], *const __stop_ods_kernels[];

typedef struct {
    int64_t type, shape[MOST_DIMENSIONS], stride, integer;
    double number;
    int64_t same, bytes;
} Taken;

static void *blocks[MOST_BLOCKS];
static int block_count;

static void *new_block(size_t bytes)
{
    void *start;
    if (block_count == MOST_BLOCKS || posix_memalign(&start, 64, bytes) != 0)
        exit(3);
    return blocks[block_count++] = start;
}

void *ods_scratch(size_t bytes) { return new_block(bytes); }

static const Kernel *find(const char *name)
{
    for (const Kernel *const *entry = __start_ods_kernels; entry < __stop_ods_kernels; entry++)
        if (strcmp((*entry)->name, name) == 0)
            return *entry;
    fprintf(stderr, "no kernel %s\n", name);
    exit(4);
}

static void take(void *target, size_t bytes, FILE *file)
{
    if (bytes != 0 && fread(target, bytes, 1, file) != 1)
        exit(5);
}

int main(int count, char **names)
{
    FILE *calls = count == 3 ? fopen(names[1], "rb") : NULL, *made = count == 3 ? fopen(names[2], "wb") : NULL;
    char name[64];
    if (calls == NULL || made == NULL)
        return 2;
    while (fread(name, sizeof name, 1, calls) == 1) {
        Argument arguments[MOST_ARGUMENTS];
        Taken taken[MOST_ARGUMENTS];
        int64_t given;
        take(&given, sizeof given, calls);
        for (int64_t k = 0; k < given; k++) {
            take(&taken[k], sizeof taken[k], calls);
            arguments[k] = (Argument){.stride = taken[k].stride, .integer = taken[k].integer, .number = taken[k].number};
            arguments[k].type = (char)taken[k].type;
            memcpy(arguments[k].shape, taken[k].shape, sizeof taken[k].shape);
            if (taken[k].type != 0)
                arguments[k].data = taken[k].same >= 0 ? arguments[taken[k].same].data : new_block((size_t)taken[k].bytes);
            take(arguments[k].data, (size_t)taken[k].bytes, calls);
        }
        const Returned returned = find(name)->run(arguments);
        fwrite(&returned, sizeof returned, 1, made);
        for (int64_t k = 0; k < given; k++)
            if (taken[k].bytes != 0)
                fwrite(arguments[k].data, (size_t)taken[k].bytes, 1, made);
        while (block_count > 0)
            free(blocks[--block_count]);
    }
    return fclose(made) != 0;
}
