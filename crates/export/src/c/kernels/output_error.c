/* The measured minus the expected output, which a functional mock-up unit has as a variable. */
#include "typical.h"

void observer_innovation(const observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *innovation)
{
#if NONLINEAR
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    NUMBER all[MEASURED];
    int i;

    measurement(t, state->xhat, u, all);
    for (i = 0; i < OUTPUTS; ++i) {
        innovation[i] = y[i] - all[i];
    }
#else
#if FILTER_FORM
    const NUMBER *const x = state->prediction;
#else
    const NUMBER *const x = state->xhat;
#endif
    int i;
    int j;

#if !HAS_FEEDTHROUGH
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
#endif
}
