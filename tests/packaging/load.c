/* Loads the kernel's library by its path, as Python does, and prints the state of the base set of
   parameters after 100 s from the static start: x, ẋ, y, ẏ as hexadecimal numbers. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return LoadLibraryA(path); }
static void *symbol(void *library, const char *name)
{
    return (void *)GetProcAddress((HMODULE)library, name);
}
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW); }
static void *symbol(void *library, const char *name) { return dlsym(library, name); }
#endif

/* Numbers in a result, of which the first four are x, ẋ, y, ẏ; greatest number of switches per
   call; and the status of a run that has not ended. */
enum { RESULTS = 22, SWITCHES = 50, RUNNING = 5 };

typedef int64_t Size(void);
typedef void Starts(const double *parameters, const uint8_t *separation, double *starts,
                    int64_t count);
typedef void Begin(void *run, const double *parameters, int64_t separation, const double *start,
                   double t_end, double tol, int64_t order);
/* Without sample times and segments their buffers may be NULL. `budget` is a number of steps. */
typedef int64_t Advance(void *run, double *switches, int64_t max_switches, const double *times,
                        int64_t time_count, double *samples, int8_t *modes, double *segments,
                        int64_t max_segments, int64_t budget, double *result);

int main(int count, char **arguments)
{
    /* m, k1, k2, k3, c1, c2, F, k_nl, μ */
    const double parameters[] = {5.0, 100.0, 50.0, 60.0, 0.32, 0.32, 80.0, 100.0, 0.7};
    const uint8_t separation = 1;
    double start[4], switches[SWITCHES], result[RESULTS];
    void *library = count == 2 ? load(arguments[1]) : NULL;
    if (!library)
        return 1;
    /* The baseline instruction set, which every processor of a platform has. */
    Size *size = (Size *)symbol(library, "fivtui_run_size_baseline");
    Starts *static_starts = (Starts *)symbol(library, "fivtui_static_starts_baseline");
    Begin *begin = (Begin *)symbol(library, "fivtui_run_begin_baseline");
    Advance *advance = (Advance *)symbol(library, "fivtui_run_advance_baseline");
    if (!size || !static_starts || !begin || !advance)
        return 2;
    void *run = malloc((size_t)size());
    if (!run)
        return 3;
    static_starts(parameters, &separation, start, 1);
    const double t_end = 100.0, tol = 1e-15;
    const int64_t order = 20;
    begin(run, parameters, separation, start, t_end, tol, order);
    while (advance(run, switches, SWITCHES, NULL, 0, NULL, NULL, NULL, 0, 1000, result) == RUNNING)
        ;
    printf("%a %a %a %a\n", result[0], result[1], result[2], result[3]);
    free(run);
    return 0;
}
