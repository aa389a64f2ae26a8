/* The choice of an instruction set; each gives the same bits. */

#include "processor.h"

#include "stepping.h"

const Stepping *stepping(void)
{
#if defined(__x86_64__) || defined(_M_X64)
    if (instruction_set() > 0)
        return &stepping_avx2;
#endif
    return &stepping_baseline;
}
