/* The step of a sampled cubic observer at varying periods: the prediction over the time that has passed, and the
 * correction. The time is the last input of both, whose columns of B and D are zero. An export defines the terms of the
 * series and the correction. */
#include "typical.h"

void observer_predict(observer_state *state, const NUMBER *u, NUMBER dt)
{
    const NUMBER tau = dt / PARTS;
    NUMBER known[INPUTS + 1];
    NUMBER term[STATES];
    NUMBER next[STATES];
    int i;
    int part;

#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        known[i] = u[i];
    }
#else
    (void)u;
#endif
    known[INPUTS] = dt;
    /* The series of the exponential in each part. */
    for (part = 0; part < PART_COUNT; ++part) {
        NUMBER degree = REAL(1.0);
        int k;
        first_term(REAL(0.0), state->xhat, known, &tau, &degree, term);
        for (i = 0; i < STATES; ++i) {
            state->xhat[i] = state->xhat[i] + term[i];
        }
        for (k = 1; k < SERIES_DEGREE; ++k) {
            degree = degree + REAL(1.0);
            next_term(REAL(0.0), term, known, &tau, &degree, next);
            for (i = 0; i < STATES; ++i) {
                term[i] = next[i];
                state->xhat[i] = state->xhat[i] + term[i];
            }
        }
    }
}

void observer_update(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER dt)
{
    NUMBER known[INPUTS + 1];
    NUMBER next[STATES];
    int i;

#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        known[i] = u[i];
    }
#else
    (void)u;
#endif
    known[INPUTS] = dt;
    corrected(REAL(0.0), state->xhat, known, y, next);
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = next[i];
    }
}

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER dt, NUMBER *xhat)
{
    int i;

    observer_predict(state, u, dt);
    observer_update(state, u, y, dt);
    if (xhat != NULL) {
        for (i = 0; i < STATES; ++i) {
            xhat[i] = state->xhat[i];
        }
    }
}
