/* Choose the functions of the motion for the instruction set of this processor; all give the same
   bits. */

#ifdef WITH_AVX2
#include "processor.h"
#endif
#include "stepping.h"

const Stepping *choose_stepping(void)
{
#ifdef WITH_AVX2
    if (instruction_set() > 0)
        return &stepping_avx2;
#endif
    return &stepping_baseline;
}
