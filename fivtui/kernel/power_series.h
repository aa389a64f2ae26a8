/* Coefficients of products, ratios and exponential functions of power series in time. */

#ifndef FIVTUI_POWER_SERIES_H
#define FIVTUI_POWER_SERIES_H

#include "field.h"

#if LANES == 1

INLINE double product(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int i = 0; i <= n; i++)
        sum += a[i] * b[n - i];
    return sum;
}

/* Of a/b, of which `ratio` has the coefficients of lower degree. */
INLINE double quotient(const double *a, const double *b, const double *ratio, int n)
{
    double rest = a[n];
    for (int i = 1; i <= n; i++)
        rest -= b[i] * ratio[n - i];
    return rest / b[0];
}

/* Of an exponential function, of which `power` has the coefficients of lower degree. */
INLINE double exponential_term(const double *exponent, const double *power, int n)
{
    double sum = 0.0;
    for (int i = 1; i <= n; i++)
        sum += i * exponent[i] * power[n - i];
    return n > 0 ? sum / n : exponential(exponent[0]);
}

#endif

#endif
