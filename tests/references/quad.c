/* Transients in quadruple precision (33 digits): Taylor series of order 30, switches by bisection.
   The spring k3 stands at 45 degrees, so half of its stiffness acts along x and y and couples them.

   Reads lines "m k1 k2 k3 c1 c2 F k_nl mu separation t_end x vx y vy" and answers each with
   "x vx y vy peak_y_abs peak_x_abs separations separated_time". Independent of the package. */

#include <quadmath.h>
#include <stdio.h>
#include <stdlib.h>

#define ORDER 30
/* Parts of a step in which signs are compared, bisections of a root, and relative local
   tolerance. */
#define SAMPLES 12
#define BISECTIONS 130
#define TOLERANCE 1e-32Q
/* Indices of the numbers of a state, and their count. */
enum { X, VX, Y, VY, STATE_SIZE };
/* Indices of numbers in a line, after the nine parameters, and the count of all numbers. */
enum { SEPARATION = 9, T_END, START, INPUTS = START + STATE_SIZE };
typedef __float128 quad;

static quad m, k1, k2, k3, c1, c2, F, knl, mu;

/* Taylor coefficients of x and y from a state. */
static void expand(const quad *state, int contact, quad *x, quad *y)
{
    quad half_k3 = k3 / 2, square[ORDER + 1];
    x[0] = state[X], x[1] = state[VX], y[0] = state[Y], y[1] = state[VY];
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
        quad coupling = half_k3 * (x[n] - y[n]), load = n ? 0 : F, divisor = m * (n + 1) * (n + 2);
        x[n + 2] = (mu * force - c1 * (n + 1) * x[n + 1] - k1 * x[n] - coupling) / divisor;
        y[n + 2] = (force - load - c2 * (n + 1) * y[n + 1] + coupling) / divisor;
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

/* Time at which function(c, t) changes its sign between low and high: to positive if `rising`, else
   from positive. The function is `value` or `slope` of a polynomial. */
static quad find_root(quad (*function)(const quad *, quad), const quad *c, quad low, quad high,
                      int rising)
{
    for (int i = 0; i < BISECTIONS; i++) {
        quad middle = (low + high) / 2;
        if ((function(c, middle) > 0) == rising)
            high = middle;
        else
            low = middle;
    }
    return high;
}

/* The greater of `peak` and the greatest absolute value of a polynomial on [0, h]. */
static quad update_peak(const quad *c, quad h, quad peak)
{
    quad last_slope = slope(c, 0), last_time = 0;
    peak = fmaxq(peak, fmaxq(fabsq(value(c, 0)), fabsq(value(c, h))));
    for (int i = 1; i <= SAMPLES; i++) {
        quad time = h * i / SAMPLES, next_slope = slope(c, time);
        if ((last_slope > 0) != (next_slope > 0)) {
            quad extremum = find_root(slope, c, last_time, time, next_slope > 0);
            peak = fmaxq(peak, fabsq(value(c, extremum)));
        }
        last_slope = next_slope, last_time = time;
    }
    return peak;
}

/* The first time after 0 at which y changes its sign; h if there is none. A step of so high an
   order may contain a flight between two samples, so y is also evaluated at its extremum between
   them. */
static quad first_switch(const quad *y, quad h, int contact, int *switched)
{
    quad low = 0, last_slope = slope(y, 0);
    for (int i = 1; i <= SAMPLES; i++) {
        /* The sample, and before it an extremum of y, if there is one since the last sample. */
        quad sample = h * i / SAMPLES, next_slope = slope(y, sample), times[2] = {sample, sample};
        if ((last_slope > 0) != (next_slope > 0))
            times[0] = find_root(slope, y, low, sample, next_slope > 0);
        for (int j = 0; j < 2; j++) {
            quad height = value(y, times[j]);
            if (contact ? height > 0 : height < 0) {
                *switched = 1;
                /* After a switch y is zero at 0, which is not the root. */
                quad start = low > 0 ? low : times[j] * 1e-12Q;
                return find_root(value, y, start, times[j], contact);
            }
            low = times[j];
        }
        last_slope = next_slope;
    }
    return h;
}

/* Whether the motion continues in contact: the first of y and its derivatives that is not zero
   decides. They are up to positive factors; each is valid if those before it are zero. The fourth
   derivative has the sign of x's acceleration, opposite to x. */
static int in_contact(const quad *state)
{
    enum { DERIVATIVES = 5 };
    quad half_k3 = k3 / 2;
    quad derivatives[DERIVATIVES] = {state[Y], state[VY], half_k3 * state[X] - F,
                                     half_k3 * state[VX], -half_k3 * state[X]};
    for (int i = 0; i < DERIVATIVES; i++)
        if (derivatives[i] != 0)
            return derivatives[i] < 0;
    return 1;
}

static void print_number(quad number)
{
    char text[64];
    quadmath_snprintf(text, sizeof text, "%.25Qg", number);
    printf("%s ", text);
}

int main(void)
{
    double inputs[INPUTS];
    for (;;) {
        for (int i = 0; i < INPUTS; i++)
            if (scanf("%lf", &inputs[i]) != 1)
                return 0;
        const double *in = inputs;
        m = *in++, k1 = *in++, k2 = *in++, k3 = *in++, c1 = *in++, c2 = *in++;
        F = *in++, knl = *in++, mu = *in++;
        int separation = inputs[SEPARATION] != 0;
        quad t = 0, t_end = inputs[T_END], state[STATE_SIZE];
        quad peak_x = 0, peak_y = 0, separated_time = 0, x[ORDER + 2], y[ORDER + 2];
        for (int i = 0; i < STATE_SIZE; i++)
            state[i] = inputs[START + i];
        int contact = separation ? in_contact(state) : 1;
        long separations = 0;
        while (t < t_end) {
            expand(state, contact, x, y);
            quad size = fabsq(F) / (k1 + k2), h = t_end - t;
            for (int i = 0; i < STATE_SIZE; i++)
                size = fmaxq(size, fabsq(state[i]));
            for (int n = ORDER; n <= ORDER + 1; n++) {
                quad last = fmaxq(fabsq(x[n]), fabsq(y[n]));
                if (last > 0)
                    h = fminq(h, powq(TOLERANCE * size / last, 1.0Q / n));
            }
            int switched = 0;
            if (separation)
                h = first_switch(y, h, contact, &switched);
            peak_x = update_peak(x, h, peak_x), peak_y = update_peak(y, h, peak_y);
            if (!contact)
                separated_time += h;
            state[X] = value(x, h), state[VX] = slope(x, h);
            state[Y] = value(y, h), state[VY] = slope(y, h);
            t += h;
            if (switched) {
                state[Y] = 0;
                separations += contact;
                contact = !contact;
            }
        }
        for (int i = 0; i < STATE_SIZE; i++)
            print_number(state[i]);
        print_number(peak_y), print_number(peak_x);
        printf("%ld ", separations);
        print_number(separated_time);
        printf("\n");
        fflush(stdout);
    }
}
