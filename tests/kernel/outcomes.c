/* The outcomes of problems in a file, alone, on belts, over tables and in lanes, written to another:
   what a machine makes of them without Python. Compiled with `single.c`, `belt.c` and `lanes.c`. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int64_t fivtui_run_size_baseline(void);
void fivtui_run_begin_baseline(void *, const double *, int64_t, const double *, double, double,
                               int64_t);
int64_t fivtui_run_advance_baseline(void *, double *, int64_t, const double *, int64_t, double *,
                                    int8_t *, double *, int64_t, int64_t, double *);
int64_t fivtui_belt_size_baseline(void);
void fivtui_belt_begin_baseline(void *, const double *, int64_t, const double *, double, double,
                                int64_t);
void fivtui_driven_begin_baseline(void *, const double *, int64_t, const double *, double, double,
                                  int64_t, int64_t, const double *, int64_t, double);
int64_t fivtui_belt_advance_baseline(void *, double *, int64_t, const double *, int64_t, double *,
                                     int8_t *, double *, int64_t, int64_t, double *);
int64_t fivtui_batch_size_baseline(void);
double fivtui_batch_advance_baseline(void *, const double *, const uint8_t *, const double *,
                                     double *, int64_t, double, double, double, int64_t, int64_t,
                                     int64_t, int64_t, int64_t, int64_t);
int64_t fivtui_batch_ended_baseline(const void *);

enum { PARAMETERS = 9, STATE = 4, RESULTS = 19, MORE = 3, RUNNING = 5, SWITCHES = 50, LINE = 64 };
enum { BELT = 12, CHANGE = 3, LEGS = 3, LEG = 10, TALLY = 26 };

/* What `emulated_results` in `test_other_machines.py` packs first. */
typedef struct {
    int64_t members, order, cubic;
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
        double result[RESULTS + MORE], switches[SWITCHES];
        fivtui_run_begin_baseline(run, parameters + i * PARAMETERS, separation[i], starts + i * STATE,
                                  header.t_end, header.tol, header.order);
        while (fivtui_run_advance_baseline(run, switches, SWITCHES, NULL, 0, NULL, NULL, NULL, 0, 701,
                                           result) == RUNNING)
            ;
        fwrite(result, sizeof(double), RESULTS, out);
    }
    double *belts = read_items(in, header.members * BELT, sizeof(double));
    double *legs = read_items(in, header.members * LEGS * LEG, sizeof(double));
    void *on_belt = malloc((size_t)fivtui_belt_size_baseline());
    for (int driven = 0; driven < 2; driven++)
        for (int64_t i = 0; i < header.members; i++) {
            double result[RESULTS + MORE + TALLY], changes[SWITCHES * CHANGE];
            const double *p = belts + i * BELT, *start = starts + i * STATE;
            if (driven)
                fivtui_driven_begin_baseline(on_belt, p, separation[i], start, header.t_end, header.tol, header.order,
                                             i % 4 > 0, legs + i * LEGS * LEG, LEGS, 80.0);
            else
                fivtui_belt_begin_baseline(on_belt, p, separation[i], start, header.t_end, header.tol, header.order);
            while (fivtui_belt_advance_baseline(on_belt, changes, SWITCHES, NULL, 0, NULL, NULL, NULL,
                                                0, 701, result) == RUNNING)
                ;
            fwrite(result, sizeof(double), RESULTS, out);
        }
    char *memory = calloc(1, (size_t)fivtui_batch_size_baseline() + LINE);
    void *work = memory + LINE - (uintptr_t)memory % LINE;
    double *results = malloc((size_t)header.members * RESULTS * sizeof(double));
    while (fivtui_batch_ended_baseline(work) < header.members)
        fivtui_batch_advance_baseline(work, parameters, separation, starts, results, header.members,
                                      header.t_end, header.tol, 20000.0, header.order, header.cubic, 1, 1, 1, 777);
    fwrite(results, sizeof(double), (size_t)(header.members * RESULTS), out);
    return fclose(out);
}
