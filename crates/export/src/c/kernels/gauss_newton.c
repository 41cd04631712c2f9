/* One Gauss-Newton step of the moving-horizon estimator: a Kalman filter forward over the window, and its adjoint
 * backward. */
#include "transition.c"
#include "angles.c"

/* A sample of the window in the filter: mean and covariance after its measurements, the product of the I - K C and the
 * sum of the C' S^-1 nu for the way back, and A to the next sample. */
typedef struct {
    NUMBER mean[STATES];
    NUMBER P[STATES][STATES];
    NUMBER keep[STATES][STATES];
    NUMBER news[STATES];
    NUMBER forward[STATES][STATES];
} filtered;

/* The outputs and their Jacobian at x, with the time and the inputs of a sample. */
static void measurement_at(const observer_sample *at, const NUMBER *x, NUMBER *all)
{
#if !DRIVEN
    (void)at;
#endif
    measurement(AT_TIME, x, AT_INPUTS, all);
}

/* The next state with the covariance of the noise and the Jacobian at x, with the time and the inputs of a sample. */
static void linearise_at(const observer_sample *at, const NUMBER *x, NUMBER *z)
{
#if !DRIVEN
    (void)at;
#endif
    linearise(AT_TIME, x, AT_INPUTS, z);
}

/* A sample with this mean and covariance before its measurements. */
static void begin(filtered *at, const NUMBER *mean, const NUMBER *P)
{
    int i;
    int j;
    for (i = 0; i < STATES; ++i) {
        at->mean[i] = mean[i];
        at->news[i] = REAL(0.0);
        for (j = 0; j < STATES; ++j) {
            at->P[i][j] = P[(i * STATES) + j];
            at->keep[i][j] = (i == j) ? REAL(1.0) : REAL(0.0);
            at->forward[i][j] = (i == j) ? REAL(1.0) : REAL(0.0);
        }
    }
}

/* The update by one measurement c x with its innovation and the variance of its noise; 0 if the innovation has no
 * positive variance. */
static int correct(filtered *at, const NUMBER *c, NUMBER innovation, NUMBER variance)
{
    NUMBER gain[STATES];
    NUMBER row[STATES];
    NUMBER once[STATES][STATES];
    NUMBER product[STATES][STATES];
    NUMBER s = variance;
    int is_right = 0;
    int i;
    int j;
    int k;

    for (i = 0; i < STATES; ++i) {
        NUMBER sum = REAL(0.0);
        for (k = 0; k < STATES; ++k) {
            sum = sum + (at->P[i][k] * c[k]);
        }
        gain[i] = sum;
    }
    for (i = 0; i < STATES; ++i) {
        s = s + (c[i] * gain[i]);
    }
    if ((s > REAL(0.0)) && (MAGNITUDE(s) <= LARGEST)) {
        const NUMBER scale = innovation / s;
        is_right = 1;
        for (i = 0; i < STATES; ++i) {
            NUMBER sum = REAL(0.0);
            for (k = 0; k < STATES; ++k) {
                sum = sum + (at->keep[k][i] * c[k]);
            }
            row[i] = sum;
            at->news[i] = at->news[i] + (sum * scale);
            gain[i] = gain[i] / s;
        }
        for (i = 0; i < STATES; ++i) {
            at->mean[i] = at->mean[i] + (gain[i] * innovation);
            for (j = 0; j < STATES; ++j) {
                at->keep[i][j] = at->keep[i][j] - (gain[i] * row[j]);
                once[i][j] = ((i == j) ? REAL(1.0) : REAL(0.0)) - (gain[i] * c[j]);
            }
        }
        /* Joseph's form. */
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = once[i][0] * at->P[0][j];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (once[i][k] * at->P[k][j]);
                }
                product[i][j] = sum;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = product[i][0] * once[j][0];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (product[i][k] * once[j][k]);
                }
                at->P[i][j] = sum + ((gain[i] * variance) * gain[j]);
            }
        }
        symmetrise(&at->P[0][0]);
    }
    return is_right;
}

/* The update by the outputs of a sample, linearised at x; with V = G G' the entries of G^-1 y are independent. */
static int measure(const observer_sample *sample, const NUMBER *x, filtered *at)
{
    NUMBER all[OUTPUTS + (OUTPUTS * STATES)];
    NUMBER *const C = &all[OUTPUTS];
    int is_right = 1;
    int i;
    int j;
    int k;

    if (sample->measured != 0) {
        measurement_at(sample, x, all);
        for (i = 0; i < OUTPUTS; ++i) {
#if ANGLES
            all[i] = wrap(sample->y[i] - all[i], TURNS[0][i]);
#else
            all[i] = sample->y[i] - all[i];
#endif
        }
        for (i = 0; i < OUTPUTS; ++i) {
            for (k = 0; k < i; ++k) {
                all[i] = all[i] - (ROOT_V[i][k] * all[k]);
                for (j = 0; j < STATES; ++j) {
                    C[(i * STATES) + j] = C[(i * STATES) + j] - (ROOT_V[i][k] * C[(k * STATES) + j]);
                }
            }
            all[i] = all[i] / ROOT_V[i][i];
            for (j = 0; j < STATES; ++j) {
                C[(i * STATES) + j] = C[(i * STATES) + j] / ROOT_V[i][i];
            }
        }
        for (i = 0; (i < OUTPUTS) && (is_right != 0); ++i) {
            NUMBER innovation = all[i];
            for (j = 0; j < STATES; ++j) {
#if ANGLES
                innovation = innovation - (C[(i * STATES) + j] * wrap(at->mean[j] - x[j], STATE_TURNS[0][j]));
#else
                innovation = innovation - (C[(i * STATES) + j] * (at->mean[j] - x[j]));
#endif
            }
            is_right = correct(at, &C[i * STATES], innovation, REAL(1.0));
        }
    }
    return is_right;
}

#if HAS_BOUNDS
/* The bounds of a sample as measurements of its states, with the variance s/z of slack and multiplier. */
static int bound(filtered *at, const NUMBER *s, const NUMBER *z, NUMBER mu)
{
    NUMBER row[STATES];
    int is_right = 1;
    int i;
    int k;

    for (k = 0; (k < BOUND_COUNT) && (is_right != 0); ++k) {
        const NUMBER value = BOUNDS[0][k] + (SIDE[k] * (s[k] + (mu / z[k])));
        for (i = 0; i < STATES; ++i) {
            row[i] = (i == BOUNDED[k]) ? REAL(1.0) : REAL(0.0);
        }
        is_right = correct(at, row, value - at->mean[BOUNDED[k]], s[k] / z[k]);
    }
    return is_right;
}
#endif

/* The mean of the next sample, F(x) + A (mean - x), before its measurements. */
static void drift(const filtered *at, const NUMBER *x, const NUMBER *z, NUMBER *mean)
{
    const NUMBER *const A = &z[STATES + (STATES * STATES)];
    NUMBER away[STATES];
    int i;
    int k;

    for (k = 0; k < STATES; ++k) {
#if ANGLES
        away[k] = wrap(at->mean[k] - x[k], STATE_TURNS[0][k]);
#else
        away[k] = at->mean[k] - x[k];
#endif
    }
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = A[i * STATES] * away[0];
        for (k = 1; k < STATES; ++k) {
            sum = sum + (A[(i * STATES) + k] * away[k]);
        }
        mean[i] = z[i] + sum;
    }
}

/* One Gauss-Newton step from x: the solution of the problem linearised along it, and the covariance of its last
 * state; 0 if there is none in floating point. */
static int pass(const observer_state *state, const NUMBER *x,
#if HAS_BOUNDS
                const NUMBER *s, const NUMBER *multipliers, NUMBER mu,
#endif
                NUMBER *solution, NUMBER *last)
{
    filtered stages[WINDOW];
    NUMBER lambda[STATES];
#if SEVERAL_SAMPLES
    NUMBER z[STATES + (2 * STATES * STATES)];
    NUMBER mean[STATES];
    NUMBER adjoint[STATES];
    NUMBER P[STATES][STATES];
    int k;
#endif
    int is_right = 1;
    int i;
    int j;
    int l;

    begin(&stages[0], state->prior, &state->prior_P[0][0]);
    for (i = 0; (i < state->count) && (is_right != 0); ++i) {
        is_right = measure(&state->samples[i], &x[i * STATES], &stages[i]);
#if HAS_BOUNDS
        if ((is_right != 0) && (s != NULL)) {
            is_right = bound(&stages[i], &s[i * BOUND_COUNT], &multipliers[i * BOUND_COUNT], mu);
        }
#endif
#if SEVERAL_SAMPLES
        if ((is_right != 0) && ((i + 1) < state->count)) {
            const NUMBER *const A = &z[STATES + (STATES * STATES)];
            linearise_at(&state->samples[i], &x[i * STATES], z);
            drift(&stages[i], &x[i * STATES], z, mean);
            spread(&stages[i].P[0][0], z, &P[0][0]);
            begin(&stages[i + 1], mean, &P[0][0]);
            for (j = 0; j < STATES; ++j) {
                for (k = 0; k < STATES; ++k) {
                    stages[i].forward[j][k] = A[(j * STATES) + k];
                }
            }
        }
#endif
    }
    for (j = 0; j < STATES; ++j) {
        lambda[j] = REAL(0.0);
    }
    for (i = state->count - 1; (i >= 0) && (is_right != 0); --i) {
#if SEVERAL_SAMPLES
        if ((i + 1) < state->count) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = REAL(0.0);
                for (k = 0; k < STATES; ++k) {
                    sum = sum + (stages[i + 1].keep[k][j] * lambda[k]);
                }
                adjoint[j] = sum - stages[i + 1].news[j];
            }
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = REAL(0.0);
                for (k = 0; k < STATES; ++k) {
                    sum = sum + (stages[i].forward[k][j] * adjoint[k]);
                }
                lambda[j] = sum;
            }
        }
#endif
        for (j = 0; j < STATES; ++j) {
            NUMBER entry = stages[i].mean[j];
            for (l = 0; l < STATES; ++l) {
                entry = entry - (stages[i].P[j][l] * lambda[l]);
            }
            solution[(i * STATES) + j] = entry;
            if (!(MAGNITUDE(entry) <= LARGEST)) {
                is_right = 0;
            }
        }
    }
    if (is_right != 0) {
        const filtered *const end = &stages[state->count - 1];
        for (j = 0; j < STATES; ++j) {
            for (l = 0; l < STATES; ++l) {
                last[(j * STATES) + l] = end->P[j][l];
            }
        }
    }
    return is_right;
}
