/* The moving-horizon estimator: measurement, prediction, and the arrival cost. The window is in arrays of fixed
 * lengths, and every loop has a fixed bound: the Gauss-Newton steps of the study, and where a bound is active as
 * many of the interior-point method as the estimator in Rust takes. */
#include "typical.h"
#include "innovation.c"
#if HAS_BOUNDS
#include "interior_point.c"
#else
#include "gauss_newton.c"
#endif

/* The trajectory of the sample before. */
static void stored(const observer_state *state, NUMBER *x)
{
    int i;
    int j;
    for (i = 0; i < WINDOW; ++i) {
        for (j = 0; j < STATES; ++j) {
            x[(i * STATES) + j] = state->samples[i].x[j];
        }
    }
}

/* The trajectory that solves the problem of the window, and the covariance of its last state without regard to
 * bounds; 0 if there is none in floating point. */
static int solve(const observer_state *state, NUMBER *x, NUMBER *P)
{
    NUMBER solution[WINDOW * STATES];
#if HAS_BOUNDS
    NUMBER other[STATES][STATES];
#endif
    int is_right = 1;
    int step;
    int i;

    stored(state, x);
    for (step = 0; (step < ITERATIONS) && (is_right != 0); ++step) {
#if HAS_BOUNDS
        is_right = pass(state, x, NULL, NULL, REAL(0.0), solution, P);
#else
        is_right = pass(state, x, solution, P);
#endif
        for (i = 0; (i < (state->count * STATES)) && (is_right != 0); ++i) {
            x[i] = solution[i];
        }
    }
#if HAS_BOUNDS
    if (is_right == 0) {
        stored(state, x);
        is_right = interior(state, x, P);
    } else if (is_within(state->count, x) == 0) {
        is_right = interior(state, x, &other[0][0]);
    } else {
        /* No bound is active. */
    }
#endif
    return is_right;
}

/* Whether the covariance of the innovation is positive definite in floating point. */
static int is_definite(const observer_state *state, const observer_sample *at)
{
    NUMBER all[OUTPUTS + (OUTPUTS * STATES)];
    NUMBER cp[OUTPUTS][STATES];
    NUMBER s[OUTPUTS][OUTPUTS];

    measurement_at(at, state->xhat, all);
    spread_of_innovation(all, &state->P[0][0], &V[0][0], &cp[0][0], &s[0][0]);
#if PARTIAL
    leave_out(at, s);
#endif
    return factorise(s);
}

/* The measurement: the problem of the window is solved with it. The state stays as it was where that has no result in
 * floating point. */
static void update(observer_state *state, NUMBER t, const NUMBER *u, const NUMBER *y)
{
    observer_sample *const at = &state->samples[state->count - 1];
    observer_sample before;
    NUMBER x[WINDOW * STATES];
    NUMBER P[STATES][STATES];
    int is_right;
    int i;
    int j;

    before = *at;
#if TIMED
    at->t = t;
#else
    (void)t;
#endif
#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        at->u[i] = u[i];
    }
#else
    (void)u;
#endif
    for (i = 0; i < OUTPUTS; ++i) {
#if PARTIAL
        at->measured[i] = (MAGNITUDE(y[i]) <= LARGEST) ? 1 : 0;
        at->y[i] = (at->measured[i] != 0) ? y[i] : REAL(0.0);
#else
        at->measured[i] = 1;
        at->y[i] = y[i];
#endif
    }
    is_right = is_definite(state, at);
    if (is_right != 0) {
        is_right = solve(state, x, &P[0][0]);
    }
    if (is_right != 0) {
        for (i = 0; i < state->count; ++i) {
            for (j = 0; j < STATES; ++j) {
                state->samples[i].x[j] = x[(i * STATES) + j];
            }
        }
        for (i = 0; i < STATES; ++i) {
            state->xhat[i] = at->x[i];
            for (j = 0; j < STATES; ++j) {
                state->P[i][j] = P[i][j];
            }
        }
    } else {
        *at = before;
    }
}

/* The first sample of the window goes into the arrival cost. 0, and nothing changes, if that has no result. */
static int forget(observer_state *state)
{
    filtered first;
    NUMBER z[STATES + (2 * STATES * STATES)];
    int is_right;
    int i;

    begin(&first, state->prior, &state->prior_P[0][0]);
    is_right = measure(&state->samples[0], state->samples[0].x, &first);
    if (is_right != 0) {
        linearise_at(&state->samples[0], state->samples[0].x, z);
        drift(&first, state->samples[0].x, z, state->prior);
        spread(&first.P[0][0], z, &state->prior_P[0][0]);
        for (i = 1; i < WINDOW; ++i) {
            state->samples[i - 1] = state->samples[i];
        }
        state->count = WINDOW - 1;
    }
    return is_right;
}

/* The prediction for the next sample; NaN, and the window as it was, where it has no result in floating point. */
static void predict(observer_state *state, NUMBER t, const NUMBER *u)
{
    observer_sample *const at = &state->samples[state->count - 1];
    observer_sample before;
    NUMBER z[STATES + (2 * STATES * STATES)];
    NUMBER P[STATES][STATES];
    int is_right = 1;
    int i;
    int j;

    before = *at;
#if TIMED
    at->t = t;
#else
    (void)t;
#endif
#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        at->u[i] = u[i];
    }
#else
    (void)u;
#endif
    linearise_at(at, at->x, z);
    spread(&state->P[0][0], z, &P[0][0]);
    for (i = 0; i < STATES; ++i) {
        if (!(MAGNITUDE(z[i]) <= LARGEST)) {
            is_right = 0;
        }
        for (j = 0; j < STATES; ++j) {
            if (!(MAGNITUDE(P[i][j]) <= LARGEST)) {
                is_right = 0;
            }
        }
    }
    if ((is_right != 0) && (state->count == WINDOW)) {
        is_right = forget(state);
    }
    if (is_right != 0) {
        observer_sample *const next = &state->samples[state->count];
        for (i = 0; i < OUTPUTS; ++i) {
            next->measured[i] = 0;
        }
        for (i = 0; i < STATES; ++i) {
            next->x[i] = z[i];
            state->xhat[i] = z[i];
            for (j = 0; j < STATES; ++j) {
                state->P[i][j] = P[i][j];
            }
        }
        ++state->count;
    } else {
        *at = before;
        for (i = 0; i < STATES; ++i) {
            state->xhat[i] = (NUMBER)NAN;
        }
    }
}
