/* Loads the kernel's library by its path, as Python does, and prints the state of the base scene
   after 100 s: four hexadecimal numbers. */

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

enum { RESULTS = 22, SWITCHES = 50, RUNNING = 5 };

typedef int64_t Size(void);
typedef void Starts(const double *, const uint8_t *, double *, int64_t);
typedef void Begin(void *, const double *, int64_t, const double *, double, double, int64_t);
typedef int64_t Advance(void *, double *, int64_t, const double *, int64_t, double *, int8_t *,
                        double *, int64_t, int64_t, double *);

int main(int count, char **arguments)
{
    const double parameters[] = {5.0, 100.0, 50.0, 60.0, 0.32, 0.32, 80.0, 100.0, 0.7};
    const uint8_t separation = 1;
    double start[4], switches[SWITCHES], result[RESULTS];
    void *library = count == 2 ? load(arguments[1]) : NULL;
    if (!library)
        return 1;
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
    begin(run, parameters, separation, start, 100.0, 1e-15, 20);
    while (advance(run, switches, SWITCHES, NULL, 0, NULL, NULL, NULL, 0, 1000, result) == RUNNING)
        ;
    printf("%a %a %a %a\n", result[0], result[1], result[2], result[3]);
    free(run);
    return 0;
}
