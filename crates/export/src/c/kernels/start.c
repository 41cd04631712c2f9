/* The start of an observer from a first estimate, with what its state has besides. */
#include "unit_vectors.c"

void observer_init(observer_state *state, const NUMBER *xhat)
{
    int i;
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = xhat[i];
    }
#if FILTER_FORM
    for (i = 0; i < STATES; ++i) {
        state->prediction[i] = xhat[i];
    }
    for (i = 0; i < OUTPUTS; ++i) {
        state->innovation[i] = REAL(0.0);
    }
#endif
#if HAS_COVARIANCE
    for (i = 0; i < STATES; ++i) {
        int j;
        for (j = 0; j < STATES; ++j) {
            state->P[i][j] = P0[i][j];
        }
    }
#endif
#if HAS_FACTOR
    for (i = 0; i < STATES; ++i) {
        int j;
        for (j = 0; j < STATES; ++j) {
            state->S[i][j] = ROOT_P0[i][j];
        }
    }
#endif
#if HAS_WINDOW
    for (i = 0; i < STATES; ++i) {
        int j;
        state->prior[i] = xhat[i];
        for (j = 0; j < STATES; ++j) {
            state->prior_P[i][j] = P0[i][j];
        }
    }
    for (i = 0; i < WINDOW; ++i) {
        int j;
        for (j = 0; j < STATES; ++j) {
            state->samples[i].x[j] = xhat[j];
        }
#if HAS_INPUTS
        for (j = 0; j < INPUTS; ++j) {
            state->samples[i].u[j] = REAL(0.0);
        }
#endif
        for (j = 0; j < OUTPUTS; ++j) {
            state->samples[i].y[j] = REAL(0.0);
            state->samples[i].measured[j] = 0;
        }
#if TIMED
        state->samples[i].t = REAL(0.0);
#endif
    }
    state->count = 1;
#endif
#if TIMED
    state->sample = 0;
#endif
#if HAS_UNIT_VECTORS
    normalise(state);
#endif
}
