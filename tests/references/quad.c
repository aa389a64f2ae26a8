/* Transients in quadruple precision (33 digits): Taylor series of order 30, switches by bisection.

   Reads lines "m k1 k2 k3 c1 c2 F k_nl mu separation t_end x vx y vy" and answers each with
   "x vx y vy peak_y_abs peak_x_abs separations separated_time". Independent of the package. */

#include <quadmath.h>
#include <stdio.h>
#include <stdlib.h>

#define ORDER 30
#define SAMPLES 12
typedef __float128 quad;

static quad m, k1, k2, k3, c1, c2, F, knl, mu;

static void expand(const quad *s, int contact, quad *x, quad *y)
{
    quad h = k3 / 2, square[ORDER + 1];
    x[0] = s[0], x[1] = s[1], y[0] = s[2], y[1] = s[3];
    for (int n = 0; n < ORDER; n++) {
        quad force = 0;
        if (contact) {
            quad cube = 0;
            square[n] = 0;
            for (int i = 0; i <= n; i++)
                square[n] += y[i] * y[n - i];
            for (int i = 0; i <= n; i++)
                cube += y[i] * square[n - i];
            force = -k2 * y[n] - knl * cube;
        }
        quad pull = h * (x[n] - y[n]), load = n ? 0 : F, divisor = m * (n + 1) * (n + 2);
        x[n + 2] = (mu * force - c1 * (n + 1) * x[n + 1] - k1 * x[n] - pull) / divisor;
        y[n + 2] = (force - load - c2 * (n + 1) * y[n + 1] + pull) / divisor;
    }
}

static quad value(const quad *c, quad t)
{
    quad total = 0;
    for (int n = ORDER + 1; n >= 0; n--)
        total = total * t + c[n];
    return total;
}

static quad slope(const quad *c, quad t)
{
    quad total = 0;
    for (int n = ORDER + 1; n >= 1; n--)
        total = total * t + n * c[n];
    return total;
}

/* Where a function that is negative at low and positive at high, or the reverse, is zero. */
static quad root(quad (*f)(const quad *, quad), const quad *c, quad low, quad high, int rising)
{
    for (int i = 0; i < 130; i++) {
        quad middle = (low + high) / 2;
        if ((f(c, middle) > 0) == rising)
            high = middle;
        else
            low = middle;
    }
    return high;
}

static quad greatest(const quad *c, quad h, quad best)
{
    quad before = slope(c, 0), at = 0;
    best = fmaxq(best, fmaxq(fabsq(value(c, 0)), fabsq(value(c, h))));
    for (int i = 1; i <= SAMPLES; i++) {
        quad t = h * i / SAMPLES, now = slope(c, t);
        if ((before > 0) != (now > 0))
            best = fmaxq(best, fabsq(value(c, root(slope, c, at, t, now > 0))));
        before = now, at = t;
    }
    return best;
}

/* The first time after 0 at which y is on the other side; h if there is none. A step of an order so
   high may hold a whole flight between two samples, so that its extremum is looked at as well. */
static quad first_switch(const quad *y, quad h, int contact, int *switched)
{
    quad low = 0, before = slope(y, 0);
    for (int i = 1; i <= SAMPLES; i++) {
        quad at = h * i / SAMPLES, now = slope(y, at), ends[2] = {at, at};
        if ((before > 0) != (now > 0))
            ends[0] = root(slope, y, low, at, now > 0);
        for (int j = 0; j < 2; j++) {
            quad there = value(y, ends[j]);
            if (contact ? there > 0 : there < 0) {
                *switched = 1;
                return root(value, y, low > 0 ? low : ends[j] * 1e-12Q, ends[j], contact);
            }
            low = ends[j];
        }
        before = now;
    }
    return h;
}

static int in_contact(const quad *s)
{
    quad h = k3 / 2, signs[5] = {s[2], s[3], h * s[0] - F, h * s[1], -h * s[0]};
    for (int i = 0; i < 5; i++)
        if (signs[i] != 0)
            return signs[i] < 0;
    return 1;
}

int main(void)
{
    double in[15];
    for (;;) {
        for (int i = 0; i < 15; i++)
            if (scanf("%lf", &in[i]) != 1)
                return 0;
        m = in[0], k1 = in[1], k2 = in[2], k3 = in[3], c1 = in[4], c2 = in[5];
        F = in[6], knl = in[7], mu = in[8];
        int separation = in[9] != 0;
        quad t = 0, t_end = in[10], s[4] = {in[11], in[12], in[13], in[14]};
        quad peak_x = 0, peak_y = 0, off = 0, x[ORDER + 2], y[ORDER + 2];
        int contact = separation ? in_contact(s) : 1;
        long separations = 0;
        while (t < t_end) {
            expand(s, contact, x, y);
            quad size = fabsq(F) / (k1 + k2), h = t_end - t;
            for (int i = 0; i < 4; i++)
                size = fmaxq(size, fabsq(s[i]));
            for (int n = ORDER; n <= ORDER + 1; n++) {
                quad last = fmaxq(fabsq(x[n]), fabsq(y[n]));
                if (last > 0)
                    h = fminq(h, powq(1e-32Q * size / last, 1.0Q / n));
            }
            int switched = 0;
            if (separation)
                h = first_switch(y, h, contact, &switched);
            peak_x = greatest(x, h, peak_x), peak_y = greatest(y, h, peak_y);
            if (!contact)
                off += h;
            s[0] = value(x, h), s[1] = slope(x, h), s[2] = value(y, h), s[3] = slope(y, h);
            t += h;
            if (switched) {
                s[2] = 0;
                separations += contact;
                contact = !contact;
            }
        }
        quad out[7] = {s[0], s[1], s[2], s[3], peak_y, peak_x, off};
        for (int i = 0; i < 7; i++) {
            char text[64];
            quadmath_snprintf(text, sizeof text, "%.25Qg", out[i]);
            printf("%s ", text);
            if (i == 5)
                printf("%ld ", separations);
        }
        printf("\n");
        fflush(stdout);
    }
}
