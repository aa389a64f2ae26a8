/* Exported names of the functions of one instruction set: fivtui_NAME_VARIANT. The build defines
   VARIANT as its name. */

#ifndef FIVTUI_VARIANT_H
#define FIVTUI_VARIANT_H

#ifndef VARIANT
#define VARIANT baseline
#endif
/* The extra level expands VARIANT before names are joined. */
#define JOINED(name, variant) fivtui_##name##_##variant
#define EXPANDED(name, variant) JOINED(name, variant)
#define NAME(name) EXPANDED(name, VARIANT)

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#endif
