/* Coefficients of products, ratios and exponentials of power series in time. LANES is 1. */

#ifndef FIVTUI_POWER_SERIES_H
#define FIVTUI_POWER_SERIES_H

#include "field.h"

#if LANES == 1

/* n-th coefficient of a b. */
INLINE double product(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int i = 0; i <= n; i++)
        sum += a[i] * b[n - i];
    return sum;
}

/* n-th coefficient of a/b; `ratio` has the lower ones. */
INLINE double quotient(const double *a, const double *b, const double *ratio, int n)
{
    double numerator = a[n];
    for (int i = 1; i <= n; i++)
        numerator -= b[i] * ratio[n - i];
    return numerator / b[0];
}

/* n-th coefficient of an exponential; `power` has the lower ones. */
INLINE double exponential_term(const double *exponent, const double *power, int n)
{
    double sum = 0.0;
    for (int i = 1; i <= n; i++)
        sum += i * exponent[i] * power[n - i];
    return n > 0 ? sum / n : exponential(exponent[0]);
}

#endif

#endif
