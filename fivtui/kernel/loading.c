/* What the loader asks of a library: of what text it is made, by which compiler, and which of its
   instruction sets this processor has. */

#include <stdint.h>

#define VARIANT loading
#include "processor.h"
#include "variant.h"

EXPORT int64_t fivtui_instruction_set(void) { return instruction_set(); }
EXPORT const char *fivtui_sources(void) { return SOURCES; }
EXPORT const char *fivtui_compiler(void) { return COMPILER; }
