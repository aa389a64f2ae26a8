/* Names of exported functions. The library has each of them once for each instruction set; the
   build defines VARIANT as the name of the set, and LIBRARY_NAME(run_size) is
   fivtui_run_size_VARIANT. */

#ifndef FIVTUI_VARIANT_H
#define FIVTUI_VARIANT_H

#ifndef VARIANT
#define VARIANT baseline
#endif
/* The extra level expands VARIANT before names are joined. */
#define JOINED(name, variant) fivtui_##name##_##variant
#define EXPANDED(name, variant) JOINED(name, variant)
#define LIBRARY_NAME(name) EXPANDED(name, VARIANT)

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#endif
