/* The choice of an instruction set; each gives the same bits. */

#ifdef WITH_AVX2
#include "processor.h"
#endif
#include "stepping.h"

const Stepping *stepping(void)
{
#ifdef WITH_AVX2
    if (instruction_set() > 0)
        return &stepping_avx2;
#endif
    return &stepping_baseline;
}
