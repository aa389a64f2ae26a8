/* Reads problems from a file and writes the results of single runs, of runs on belts and with
   tables over time, and of a batch to another. So a machine without Python computes them. Compiled
   with `single.c`, `belt.c` and `lanes.c`, which computes a batch side by side in SIMD vectors. */

#include <stdio.h>
#include <stdlib.h>

#include "exports.h"

/* Rows of a table over time, capacity for switches, and steps per call. */
enum { TABLE_ROWS = 3, MAX_SWITCHES = 50, BUDGET = 701, BATCH_BUDGET = 777 };
/* `GREATEST_LOAD` is that of `random_belts` in `test_other_machines.py`, N. */
static const double MAX_STEPS = 20000.0, GREATEST_LOAD = 80.0;

/* What `emulated_results` in `test_other_machines.py` packs first. `all_cubic` says whether all
   members have a cubic contact spring, k_nl > 0; else none has. */
typedef struct {
    int64_t members, order, all_cubic;
    double t_end, tol;
} Header;

static void *read_items(FILE *file, int64_t count, size_t size)
{
    void *memory = malloc((size_t)count * size);
    if (fread(memory, size, (size_t)count, file) != (size_t)count)
        exit(1);
    return memory;
}

int main(int count, char **arguments)
{
    FILE *in = count == 3 ? fopen(arguments[1], "rb") : NULL;
    FILE *out = count == 3 ? fopen(arguments[2], "wb") : NULL;
    Header header;
    if (!in || !out || fread(&header, sizeof header, 1, in) != 1)
        return 1;
    double *parameters = read_items(in, header.members * PARAMETERS, sizeof(double));
    double *starts = read_items(in, header.members * STATE, sizeof(double));
    uint8_t *separation = read_items(in, header.members, 1);
    void *run = malloc((size_t)fivtui_run_size_baseline());
    for (int64_t i = 0; i < header.members; i++) {
        double result[RESULTS + COUNTS], switches[MAX_SWITCHES];
        fivtui_run_begin_baseline(run, parameters + i * PARAMETERS, separation[i],
                                  starts + i * STATE, header.t_end, header.tol, header.order);
        while (fivtui_run_advance_baseline(run, switches, MAX_SWITCHES, NULL, 0, NULL, NULL, NULL,
                                           0, BUDGET, result) == RUNNING)
            ;
        fwrite(result, sizeof(double), RESULTS, out);
    }
    double *belts = read_items(in, header.members * BELT_PARAMETERS, sizeof(double));
    double *table_rows = read_items(in, header.members * TABLE_ROWS * ROW_COLUMNS, sizeof(double));
    void *on_belt = malloc((size_t)fivtui_belt_size_baseline());
    /* First runs with constant parameters, then `driven` ones, with a table over time. */
    for (int driven = 0; driven < 2; driven++)
        for (int64_t i = 0; i < header.members; i++) {
            double result[RESULTS + COUNTS + TALLY], changes[MAX_SWITCHES * CHANGE_COLUMNS];
            const double *p = belts + i * BELT_PARAMETERS, *start = starts + i * STATE;
            double *rows = table_rows + i * TABLE_ROWS * ROW_COLUMNS;
            /* Every fourth driven run is on a belt that is always faster, whatever the belt in p. */
            const int finite = i % 4 > 0;
            if (driven)
                fivtui_driven_begin_baseline(on_belt, p, separation[i], start, header.t_end,
                                             header.tol, header.order, finite, rows, TABLE_ROWS,
                                             GREATEST_LOAD);
            else
                fivtui_belt_begin_baseline(on_belt, p, separation[i], start, header.t_end,
                                           header.tol, header.order);
            while (fivtui_belt_advance_baseline(on_belt, changes, MAX_SWITCHES, NULL, 0, NULL, NULL,
                                                NULL, 0, BUDGET, result) == RUNNING)
                ;
            fwrite(result, sizeof(double), RESULTS, out);
        }
    char *memory = calloc(1, (size_t)fivtui_batch_size_baseline() + CACHE_LINE);
    void *work = memory + CACHE_LINE - (uintptr_t)memory % CACHE_LINE;
    double *results = malloc((size_t)header.members * RESULTS * sizeof(double));
    while (fivtui_batch_ended_baseline(work) < header.members)
        /* The ones select extremes of y, all extremes, and those of y in the second half. */
        fivtui_batch_advance_baseline(work, parameters, separation, starts, results, header.members,
                                      header.t_end, header.tol, MAX_STEPS, header.order,
                                      header.all_cubic, 1, 1, 1, BATCH_BUDGET);
    fwrite(results, sizeof(double), (size_t)(header.members * RESULTS), out);
    return fclose(out);
}
