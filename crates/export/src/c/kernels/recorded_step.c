/* The step of an observer whose step is straight-line code as a whole: motion, whose inputs are (u, y). */
#include "typical.h"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    NUMBER known[INPUTS + OUTPUTS];
    NUMBER next[STATES];
    int i;

#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        known[i] = u[i];
    }
#else
    (void)u;
#endif
    for (i = 0; i < OUTPUTS; ++i) {
        known[INPUTS + i] = y[i];
    }
    motion(t, state->xhat, known, next);
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
