/* One Gauss-Newton step of the moving-horizon estimator: a Kalman filter forward over the window, and its adjoint
 * backward. */
#include "transition.c"
#include "angles.c"
#include "innovation.c"

/* A sample of the window in the filter: mean and covariance after its measurements, their rows, gains and nu/s for the
 * way back, and A to the next sample. */
typedef struct {
    NUMBER mean[STATES];
    NUMBER P[STATES][STATES];
    NUMBER rows[OUTPUTS][STATES];
    NUMBER gains[OUTPUTS][STATES];
    NUMBER news[OUTPUTS];
#if HAS_BOUNDS
    NUMBER bound_gains[BOUND_COUNT][STATES];
    NUMBER bound_news[BOUND_COUNT];
#endif
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

/* A sample with this mean and covariance before its measurements, of which there are none yet. */
static void begin(filtered *at, const NUMBER *mean, const NUMBER *P)
{
    int i;
    int j;
    for (i = 0; i < STATES; ++i) {
        at->mean[i] = mean[i];
        for (j = 0; j < STATES; ++j) {
            at->P[i][j] = P[(i * STATES) + j];
            at->forward[i][j] = (i == j) ? REAL(1.0) : REAL(0.0);
        }
    }
    for (i = 0; i < OUTPUTS; ++i) {
        at->news[i] = REAL(0.0);
        for (j = 0; j < STATES; ++j) {
            at->rows[i][j] = REAL(0.0);
            at->gains[i][j] = REAL(0.0);
        }
    }
}

/* M' c, for M by rows. */
static void across(const NUMBER *M, const NUMBER *c, NUMBER *result)
{
    int i;
    int k;
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = REAL(0.0);
        for (k = 0; k < STATES; ++k) {
            sum = sum + (M[(k * STATES) + i] * c[k]);
        }
        result[i] = sum;
    }
}

/* The update by one measurement c x of an innovation with the variance s, up to A' in the place of P, with the gain
 * K = P c/s and A = P - K (P c)'; 0 if s is not a positive number. */
static int weigh(filtered *at, const NUMBER *pc, NUMBER innovation, NUMBER s, NUMBER *gain, NUMBER *news)
{
    int is_right = 0;
    int i;
    int j;

    if ((s > REAL(0.0)) && (MAGNITUDE(s) <= LARGEST)) {
        is_right = 1;
        *news = innovation / s;
        for (i = 0; i < STATES; ++i) {
            gain[i] = pc[i] / s;
        }
        for (i = 0; i < STATES; ++i) {
            at->mean[i] = at->mean[i] + (gain[i] * innovation);
            for (j = 0; j < STATES; ++j) {
                at->P[i][j] = at->P[i][j] - (pc[i] * gain[j]);
            }
        }
    }
    return is_right;
}

/* P = A - (A c) K' + K v K' from A' in its place: Joseph's form, in which A c takes away what rounding left in the
 * direction c. */
static void settle(filtered *at, const NUMBER *left, const NUMBER *gain, NUMBER variance)
{
    int i;
    int j;
    for (i = 0; i < STATES; ++i) {
        const NUMBER noise = gain[i] * variance;
        for (j = 0; j <= i; ++j) {
            const NUMBER entry = (at->P[j][i] - (left[i] * gain[j])) + (noise * gain[j]);
            at->P[i][j] = entry;
            at->P[j][i] = entry;
        }
    }
}

/* The update by an output, whose row is stored, with a noise of the variance 1. */
static int take_output(filtered *at, int output, NUMBER innovation)
{
    const NUMBER *const c = at->rows[output];
    NUMBER product[STATES];
    NUMBER s = REAL(0.0);
    int is_right;
    int i;

    across(&at->P[0][0], c, product);
    for (i = 0; i < STATES; ++i) {
        s = s + (c[i] * product[i]);
    }
    is_right = weigh(at, product, innovation, s + REAL(1.0), at->gains[output], &at->news[output]);
    if (is_right != 0) {
        across(&at->P[0][0], c, product);
        settle(at, product, at->gains[output], REAL(1.0));
    }
    return is_right;
}

/* Whether an output of a sample was measured. */
static int is_measured(const observer_sample *sample)
{
    int any = 0;
    int i;
    for (i = 0; i < OUTPUTS; ++i) {
        any = (sample->measured[i] != 0) ? 1 : any;
    }
    return any;
}

#if PARTIAL
/* A covariance of the outputs with 1 for what was not measured, and nothing beside it. */
static void leave_out(const observer_sample *sample, NUMBER s[OUTPUTS][OUTPUTS])
{
    int i;
    int j;
    for (i = 0; i < OUTPUTS; ++i) {
        for (j = 0; j < OUTPUTS; ++j) {
            if ((sample->measured[i] == 0) || (sample->measured[j] == 0)) {
                s[i][j] = (i == j) ? REAL(1.0) : REAL(0.0);
            }
        }
    }
}

/* The factor G of V = G G' without what was not measured; 0 if there is none in floating point. */
static int root_of_noise(const observer_sample *sample, NUMBER root[OUTPUTS][OUTPUTS])
{
    int is_whole = 1;
    int i;
    int j;
    for (i = 0; i < OUTPUTS; ++i) {
        is_whole = (sample->measured[i] != 0) ? is_whole : 0;
    }
    for (i = 0; i < OUTPUTS; ++i) {
        for (j = 0; j < OUTPUTS; ++j) {
            root[i][j] = (is_whole != 0) ? ROOT_V[i][j] : V[i][j];
        }
    }
    if (is_whole == 0) {
        leave_out(sample, root);
        is_whole = factorise(root);
    }
    return is_whole;
}
#endif

/* The update by the outputs of a sample, linearised at x; with V = G G' the entries of G^-1 y are independent. */
static int measure(const observer_sample *sample, const NUMBER *x, filtered *at)
{
    NUMBER all[OUTPUTS + (OUTPUTS * STATES)];
    NUMBER *const C = &all[OUTPUTS];
#if PARTIAL
    NUMBER root[OUTPUTS][OUTPUTS];
    const NUMBER *const G = &root[0][0];
#else
    const NUMBER *const G = &ROOT_V[0][0];
#endif
    int is_right = 1;
    int i;
    int j;
    int k;

    if (is_measured(sample) != 0) {
        measurement_at(sample, x, all);
        for (i = 0; i < OUTPUTS; ++i) {
#if ANGLES
            all[i] = wrap(sample->y[i] - all[i], TURNS[0][i]);
#else
            all[i] = sample->y[i] - all[i];
#endif
#if PARTIAL
            if (sample->measured[i] == 0) {
                all[i] = REAL(0.0);
                for (j = 0; j < STATES; ++j) {
                    C[(i * STATES) + j] = REAL(0.0);
                }
            }
#endif
        }
#if PARTIAL
        is_right = root_of_noise(sample, root);
#endif
        for (i = 0; (i < OUTPUTS) && (is_right != 0); ++i) {
            for (k = 0; k < i; ++k) {
                all[i] = all[i] - (G[(i * OUTPUTS) + k] * all[k]);
                for (j = 0; j < STATES; ++j) {
                    C[(i * STATES) + j] = C[(i * STATES) + j] - (G[(i * OUTPUTS) + k] * C[(k * STATES) + j]);
                }
            }
            all[i] = all[i] / G[(i * OUTPUTS) + i];
            for (j = 0; j < STATES; ++j) {
                C[(i * STATES) + j] = C[(i * STATES) + j] / G[(i * OUTPUTS) + i];
            }
        }
        for (i = 0; (i < OUTPUTS) && (is_right != 0); ++i) {
            NUMBER innovation = all[i];
            for (j = 0; j < STATES; ++j) {
                at->rows[i][j] = C[(i * STATES) + j];
#if ANGLES
                innovation = innovation - (C[(i * STATES) + j] * wrap(at->mean[j] - x[j], STATE_TURNS[0][j]));
#else
                innovation = innovation - (C[(i * STATES) + j] * (at->mean[j] - x[j]));
#endif
            }
            is_right = take_output(at, i, innovation);
        }
    }
    return is_right;
}

#if HAS_BOUNDS
/* The bounds of a sample as measurements of its states, with the variance s/z of slack and multiplier. */
static int bound(filtered *at, const NUMBER *s, const NUMBER *z, NUMBER mu)
{
    NUMBER product[STATES];
    int is_right = 1;
    int i;
    int k;

    for (k = 0; (k < BOUND_COUNT) && (is_right != 0); ++k) {
        const int j = BOUNDED[k];
        const NUMBER value = BOUNDS[0][k] + (SIDE[k] * (s[k] + (mu / z[k])));
        const NUMBER variance = s[k] / z[k];
        for (i = 0; i < STATES; ++i) {
            product[i] = at->P[j][i];
        }
        is_right = weigh(at, product, value - at->mean[j], product[j] + variance, at->bound_gains[k], &at->bound_news[k]);
        if (is_right != 0) {
            for (i = 0; i < STATES; ++i) {
                product[i] = at->P[j][i];
            }
            settle(at, product, at->bound_gains[k], variance);
        }
    }
    return is_right;
}
#endif

#if SEVERAL_SAMPLES
/* K' mu + nu/s of a measurement, by which its row changes the adjoint variables mu on the way back. */
static NUMBER weight(const NUMBER *gain, NUMBER news, const NUMBER *adjoint)
{
    NUMBER sum = REAL(0.0);
    int i;
    for (i = 0; i < STATES; ++i) {
        sum = sum + (gain[i] * adjoint[i]);
    }
    return sum + news;
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
            const filtered *const next = &stages[i + 1];
#if HAS_BOUNDS
            if (s != NULL) {
                for (k = BOUND_COUNT - 1; k >= 0; --k) {
                    lambda[BOUNDED[k]] = lambda[BOUNDED[k]] - weight(next->bound_gains[k], next->bound_news[k], lambda);
                }
            }
#endif
            for (k = OUTPUTS - 1; k >= 0; --k) {
                const NUMBER change = weight(next->gains[k], next->news[k], lambda);
                for (j = 0; j < STATES; ++j) {
                    lambda[j] = lambda[j] - (next->rows[k][j] * change);
                }
            }
            across(&stages[i].forward[0][0], lambda, adjoint);
            for (j = 0; j < STATES; ++j) {
                lambda[j] = adjoint[j];
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
