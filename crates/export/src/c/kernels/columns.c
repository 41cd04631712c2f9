/* Columns that are added to triangular factors by rotations, and taken away by hyperbolic ones. */
#include "typical.h"

/* The rotation that takes (pivot, entry) to (r, 0): r, with cosine and sine. */
static NUMBER rotation(NUMBER pivot, NUMBER entry, NUMBER *c, NUMBER *d)
{
    const NUMBER r = ROOT((pivot * pivot) + (entry * entry));
    if (r == REAL(0.0)) {
        *c = REAL(0.0);
        *d = REAL(0.0);
    } else {
        *c = pivot / r;
        *d = entry / r;
    }
    return r;
}

/* The lower triangular factor of s s' + v v', by rows; v is used up. */
static void add(NUMBER *s, NUMBER *v, int order)
{
    int i;
    int j;
    for (j = 0; j < order; ++j) {
        NUMBER c;
        NUMBER d;
        const NUMBER r = rotation(s[(j * order) + j], v[j], &c, &d);
        if (r != REAL(0.0)) {
            s[(j * order) + j] = r;
            for (i = j + 1; i < order; ++i) {
                const NUMBER below = s[(i * order) + j];
                const NUMBER entry = v[i];
                s[(i * order) + j] = (c * below) + (d * entry);
                v[i] = (c * entry) - (d * below);
            }
        }
    }
}

/* The same for the factor [g, 0; m, s] and the column (a, b). */
static void add_joint(NUMBER *g, NUMBER *m, NUMBER *s, NUMBER *a, NUMBER *b)
{
    int i;
    int j;
    for (j = 0; j < OUTPUTS; ++j) {
        NUMBER c;
        NUMBER d;
        const NUMBER r = rotation(g[(j * OUTPUTS) + j], a[j], &c, &d);
        if (r != REAL(0.0)) {
            g[(j * OUTPUTS) + j] = r;
            for (i = j + 1; i < OUTPUTS; ++i) {
                const NUMBER below = g[(i * OUTPUTS) + j];
                const NUMBER entry = a[i];
                g[(i * OUTPUTS) + j] = (c * below) + (d * entry);
                a[i] = (c * entry) - (d * below);
            }
            for (i = 0; i < STATES; ++i) {
                const NUMBER below = m[(i * OUTPUTS) + j];
                const NUMBER entry = b[i];
                m[(i * OUTPUTS) + j] = (c * below) + (d * entry);
                b[i] = (c * entry) - (d * below);
            }
        }
    }
    add(s, b, STATES);
}

#if NEGATIVE_CENTRE
/* The lower triangular factor of s s' - v v', by rows; v is used up. 0 if there is none. */
static int subtract(NUMBER *s, NUMBER *v, int order)
{
    int is_right = 1;
    int i;
    int j;
    for (j = 0; (j < order) && (is_right != 0); ++j) {
        const NUMBER pivot = s[(j * order) + j];
        const NUMBER square = (pivot - v[j]) * (pivot + v[j]);
        if (v[j] != REAL(0.0)) {
            if (square > REAL(0.0)) {
                const NUMBER r = ROOT(square);
                const NUMBER c = r / pivot;
                const NUMBER d = v[j] / pivot;
                s[(j * order) + j] = r;
                for (i = j + 1; i < order; ++i) {
                    const NUMBER below = (s[(i * order) + j] - (d * v[i])) / c;
                    s[(i * order) + j] = below;
                    v[i] = (c * v[i]) - (d * below);
                }
            } else {
                is_right = 0;
            }
        }
    }
    return is_right;
}

/* The same for the factor [g, 0; m, s] and the column (a, b). */
static int subtract_joint(NUMBER *g, NUMBER *m, NUMBER *s, NUMBER *a, NUMBER *b)
{
    int is_right = 1;
    int i;
    int j;
    for (j = 0; (j < OUTPUTS) && (is_right != 0); ++j) {
        const NUMBER pivot = g[(j * OUTPUTS) + j];
        const NUMBER square = (pivot - a[j]) * (pivot + a[j]);
        if (a[j] != REAL(0.0)) {
            if (square > REAL(0.0)) {
                const NUMBER r = ROOT(square);
                const NUMBER c = r / pivot;
                const NUMBER d = a[j] / pivot;
                g[(j * OUTPUTS) + j] = r;
                for (i = j + 1; i < OUTPUTS; ++i) {
                    const NUMBER below = (g[(i * OUTPUTS) + j] - (d * a[i])) / c;
                    g[(i * OUTPUTS) + j] = below;
                    a[i] = (c * a[i]) - (d * below);
                }
                for (i = 0; i < STATES; ++i) {
                    const NUMBER below = (m[(i * OUTPUTS) + j] - (d * b[i])) / c;
                    m[(i * OUTPUTS) + j] = below;
                    b[i] = (c * b[i]) - (d * below);
                }
            } else {
                is_right = 0;
            }
        }
    }
    if (is_right != 0) {
        is_right = subtract(s, b, STATES);
    }
    return is_right;
}
#endif
