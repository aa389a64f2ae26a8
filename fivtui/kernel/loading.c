/* Properties that the loader reads: the digest of the library's sources, its compiler, and the best
   instruction set of this processor. */

#include <stdint.h>

#include "processor.h"
#include "variant.h"

/* Unlike the functions of the kernel these are there once, not for each instruction set. The set is
   an index of INSTRUCTION_SETS in `fivtui.kernel.native`. */
EXPORT int64_t fivtui_instruction_set(void) { return instruction_set(); }
EXPORT const char *fivtui_sources(void) { return SOURCES; }
EXPORT const char *fivtui_compiler(void) { return COMPILER; }
