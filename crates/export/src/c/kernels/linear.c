/* The step of a sampled observer of a linear plant, with or without a cubic part or in filter form. */
#include "typical.h"
#if CUBIC
#include "cubic_flow.c"
#endif

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if FILTER_FORM
    NUMBER *const x = state->prediction;
#else
    NUMBER *const x = state->xhat;
#endif
    NUMBER innovation[OUTPUTS];
    NUMBER next[STATES];
#if CUBIC
    NUMBER impulse[OUTPUTS];
    NUMBER moved[STATES];
#endif
    int i;
    int j;

#if !HAS_INPUTS
    (void)u;
#endif
    for (i = 0; i < OUTPUTS; ++i) {
        NUMBER sum = C[i][0] * x[0];
        for (j = 1; j < STATES; ++j) {
            sum = (C[i][j] * x[j]) + sum;
        }
        innovation[i] = y[i] - sum;
    }
#if HAS_FEEDTHROUGH
    for (i = 0; i < OUTPUTS; ++i) {
        NUMBER sum = D[i][0] * u[0];
        for (j = 1; j < INPUTS; ++j) {
            sum = (D[i][j] * u[j]) + sum;
        }
        innovation[i] = innovation[i] - sum;
    }
#endif
#if FILTER_FORM
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = UPDATE[i][0] * innovation[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (UPDATE[i][j] * innovation[j]) + sum;
        }
        state->xhat[i] = x[i] + sum;
    }
#endif
#if CUBIC
    flow(innovation, impulse, PERIOD);
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = N[i][0] * impulse[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (N[i][j] * impulse[j]) + sum;
        }
        moved[i] = x[i] - sum;
    }
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = A[i][0] * moved[0];
        for (j = 1; j < STATES; ++j) {
            sum = (A[i][j] * moved[j]) + sum;
        }
        next[i] = sum;
    }
#else
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = A[i][0] * x[0];
        for (j = 1; j < STATES; ++j) {
            sum = (A[i][j] * x[j]) + sum;
        }
        next[i] = sum;
    }
#endif
#if HAS_INPUTS
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = B[i][0] * u[0];
        for (j = 1; j < INPUTS; ++j) {
            sum = (B[i][j] * u[j]) + sum;
        }
        next[i] = next[i] + sum;
    }
#endif
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = L[i][0] * innovation[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (L[i][j] * innovation[j]) + sum;
        }
        next[i] = next[i] + sum;
    }
    for (i = 0; i < STATES; ++i) {
        x[i] = next[i];
        if (xhat != NULL) {
            xhat[i] = state->xhat[i];
        }
    }
}
