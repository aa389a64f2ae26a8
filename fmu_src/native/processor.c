/* Choose which build of `stepping.c`, which computes the slider's motion, runs on this processor:
   that with AVX2 and fused operations, or the baseline. Both give the same bits. */

#ifdef WITH_AVX2
#include "processor.h"
#endif
#include "stepping.h"

const Stepping *choose_stepping(void)
{
#ifdef WITH_AVX2
    /* 0 means that this processor has the baseline alone; higher numbers include AVX2. */
    if (instruction_set() > 0)
        return &stepping_avx2;
#endif
    return &stepping_baseline;
}
