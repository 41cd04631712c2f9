/* The step of the copy of a plant in discrete time with a constant gain: xhat+ = f + L (y - h). */
#include "typical.h"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    NUMBER innovation[OUTPUTS];
    NUMBER next[STATES];
    int i;
    int j;

    measurement(t, state->xhat, u, innovation);
    motion(t, state->xhat, u, next);
    for (i = 0; i < OUTPUTS; ++i) {
        innovation[i] = y[i] - innovation[i];
    }
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = L[i][0] * innovation[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (L[i][j] * innovation[j]) + sum;
        }
        next[i] = next[i] + sum;
    }
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = next[i];
        if (xhat != NULL) {
            xhat[i] = next[i];
        }
    }
#if TIMED
    ++state->sample;
#endif
}
