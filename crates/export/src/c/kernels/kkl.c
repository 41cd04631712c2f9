/* The numerical KKL observer: a linear filter of the output, with a copy of the plant that predicts the output between
 * samples, and a left inverse of its map T. The export defines the left inverse, which is a tree of polynomials with or
 * without a search in the table of T, and the matrices FILTER, B, WHITEN and COLOUR. */
#include "nearest.c"

/* The estimate: the state whose image is z, in its box; for held inputs that of their value u. */
static void left_inverse(const NUMBER *z, const NUMBER *u, NUMBER *xhat)
{
    NUMBER shifted[TARGETS];
    NUMBER w[TARGETS + INPUTS];
#if HAS_SEARCH
#if SEVERAL_TABLES
    NUMBER shares[TABLES];
#else
    const NUMBER *const shares = NULL;
#endif
#endif
    int i;
    int j;

    for (i = 0; i < TARGETS; ++i) {
        shifted[i] = z[i] - MEAN[i][0];
    }
    for (i = 0; i < TARGETS; ++i) {
        NUMBER sum = WHITEN[i][0] * shifted[0];
        for (j = 1; j < TARGETS; ++j) {
            sum = (WHITEN[i][j] * shifted[j]) + sum;
        }
        w[i] = (MAGNITUDE(sum) <= LARGEST) ? sum : REAL(0.0);
    }
#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        w[TARGETS + i] = between(u[i], LEAST_INPUT[i][0], MOST_INPUT[i][0]);
    }
#else
    (void)u;
#endif
    inverse(w, xhat);
    for (i = 0; i < STATES; ++i) {
        xhat[i] = between(xhat[i], LOWER[i][0], UPPER[i][0]);
    }
#if HAS_SEARCH
#if SEVERAL_TABLES
    share(&w[TARGETS], shares);
#endif
#if HAS_RESTARTS
    search(shares, w, xhat);
#else
    (void)nearest(shares, w, xhat);
#endif
#endif
}

void observer_init(observer_state *state, const NUMBER *xhat)
{
    NUMBER x[STATES + INPUTS];
    NUMBER w[TARGETS];
#if HAS_TABLE
    NUMBER jacobian[TARGETS * STATES];
#if SEVERAL_TABLES
    NUMBER shares[TABLES];
#endif
#endif
    int i;
    int j;

    for (i = 0; i < STATES; ++i) {
        x[i] = between(xhat[i], LOWER[i][0], UPPER[i][0]);
    }
#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        x[STATES + i] = between(FIRST_INPUT[i][0], LEAST_INPUT[i][0], MOST_INPUT[i][0]);
    }
#endif
#if HAS_TABLE
#if SEVERAL_TABLES
    share(&x[STATES], shares);
    table(shares, x, w, jacobian);
#else
    table(NULL, x, w, jacobian);
#endif
#else
    forward(x, w);
#endif
    for (i = 0; i < TARGETS; ++i) {
        NUMBER sum = COLOUR[i][0] * w[0];
        for (j = 1; j < TARGETS; ++j) {
            sum = (COLOUR[i][j] * w[j]) + sum;
        }
        state->z[i] = MEAN[i][0] + sum;
    }
#if HAS_INPUTS
    left_inverse(state->z, &FIRST_INPUT[0][0], state->xhat);
#else
    left_inverse(state->z, NULL, state->xhat);
#endif
#if TIMED
    state->sample = 0;
#endif
}
