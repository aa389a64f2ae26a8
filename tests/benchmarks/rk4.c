/* RK4 of fixed step with bisection at every switch: what one would write by hand. */

typedef struct {
    double m, k1, k2, k3, c1, c2, F, k_nl, mu;
} parameters;

static void slope(const parameters *p, const double *s, int contact, double *d)
{
    double P = contact ? -p->k2 * s[2] - p->k_nl * s[2] * s[2] * s[2] : 0.0;
    double pull = 0.5 * p->k3 * (s[0] - s[2]);
    d[0] = s[1];
    d[1] = (p->mu * P - p->c1 * s[1] - p->k1 * s[0] - pull) / p->m;
    d[2] = s[3];
    d[3] = (P - p->F - p->c2 * s[3] + pull) / p->m;
}

static void step(const parameters *p, const double *s, int contact, double h, double *out)
{
    double a[4], b[4], c[4], d[4], at[4];
    slope(p, s, contact, a);
    for (int i = 0; i < 4; i++)
        at[i] = s[i] + 0.5 * h * a[i];
    slope(p, at, contact, b);
    for (int i = 0; i < 4; i++)
        at[i] = s[i] + 0.5 * h * b[i];
    slope(p, at, contact, c);
    for (int i = 0; i < 4; i++)
        at[i] = s[i] + h * c[i];
    slope(p, at, contact, d);
    for (int i = 0; i < 4; i++)
        out[i] = s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
}

static int crossed(const double *s, int contact, int separation)
{
    return separation && (contact ? s[2] > 0.0 : s[2] < 0.0);
}

void run(const parameters *p, double *s, int contact, int separation, double h, long steps)
{
    double next[4];
    for (long n = 0; n < steps; n++) {
        double left = h;
        while (left > 0.0) {
            double part = left;
            step(p, s, contact, part, next);
            if (crossed(next, contact, separation)) {
                double low = 0.0, high = left;
                for (int i = 0; i < 60; i++) {
                    part = 0.5 * (low + high);
                    step(p, s, contact, part, next);
                    if (crossed(next, contact, separation))
                        high = part;
                    else
                        low = part;
                }
                part = high;
                step(p, s, contact, part, next);
                contact = !contact;
            }
            for (int i = 0; i < 4; i++)
                s[i] = next[i];
            left -= part;
        }
    }
}
