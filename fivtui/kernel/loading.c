/* Properties that the loader reads: the digest of the library's sources, its compiler, and the best
   instruction set of this processor. */

#include <stdint.h>

/* Not used here: these names are the same for all instruction sets. */
#define VARIANT loading
#include "processor.h"
#include "variant.h"

EXPORT int64_t fivtui_instruction_set(void) { return instruction_set(); }
EXPORT const char *fivtui_sources(void) { return SOURCES; }
EXPORT const char *fivtui_compiler(void) { return COMPILER; }
