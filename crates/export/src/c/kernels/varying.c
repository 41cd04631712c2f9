/* The step of a sampled cubic observer at varying periods: the prediction over the time that has passed, and the
 * correction. The time is the last input of B and D, whose column is zero. */
#include "cubic_flow.c"

void observer_predict(observer_state *state, const NUMBER *u, NUMBER dt)
{
    const NUMBER tau = dt / PARTS;
    NUMBER known[INPUTS + 1];
    NUMBER driven[STATES];
    NUMBER term[STATES];
    NUMBER next[STATES];
    int i;
    int j;
    int part;

#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        known[i] = u[i];
    }
#else
    (void)u;
#endif
    known[INPUTS] = dt;
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = B[i][0] * known[0];
        for (j = 1; j < (INPUTS + 1); ++j) {
            sum = (B[i][j] * known[j]) + sum;
        }
        driven[i] = sum;
    }
    /* The series of the exponential in each part. */
    for (part = 0; part < PART_COUNT; ++part) {
        NUMBER degree = REAL(0.0);
        int k;
        for (i = 0; i < STATES; ++i) {
            term[i] = state->xhat[i];
        }
        for (k = 0; k < SERIES_DEGREE; ++k) {
            degree = degree + REAL(1.0);
            for (i = 0; i < STATES; ++i) {
                NUMBER sum = A[i][0] * term[0];
                for (j = 1; j < STATES; ++j) {
                    sum = (A[i][j] * term[j]) + sum;
                }
                next[i] = (k == 0) ? (sum + driven[i]) : sum;
            }
            for (i = 0; i < STATES; ++i) {
                term[i] = ((next[i] * tau) / degree);
                state->xhat[i] = state->xhat[i] + term[i];
            }
        }
    }
}

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER dt, NUMBER *xhat)
{
    NUMBER innovation[OUTPUTS];
    NUMBER impulse[OUTPUTS];
#if HAS_FEEDTHROUGH
    NUMBER known[INPUTS + 1];
#endif
    int i;
    int j;

    observer_predict(state, u, dt);
    for (i = 0; i < OUTPUTS; ++i) {
        NUMBER sum = C[i][0] * state->xhat[0];
        for (j = 1; j < STATES; ++j) {
            sum = (C[i][j] * state->xhat[j]) + sum;
        }
        innovation[i] = y[i] - sum;
    }
#if HAS_FEEDTHROUGH
    for (i = 0; i < INPUTS; ++i) {
        known[i] = u[i];
    }
    known[INPUTS] = dt;
    for (i = 0; i < OUTPUTS; ++i) {
        NUMBER sum = D[i][0] * known[0];
        for (j = 1; j < (INPUTS + 1); ++j) {
            sum = (D[i][j] * known[j]) + sum;
        }
        innovation[i] = innovation[i] - sum;
    }
#endif
    flow(innovation, impulse, dt);
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = N[i][0] * impulse[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (N[i][j] * impulse[j]) + sum;
        }
        state->xhat[i] = state->xhat[i] - sum;
    }
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = GAIN[i][0] * innovation[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (GAIN[i][j] * innovation[j]) + sum;
        }
        state->xhat[i] = state->xhat[i] + sum;
    }
    if (xhat != NULL) {
        for (i = 0; i < STATES; ++i) {
            xhat[i] = state->xhat[i];
        }
    }
}
