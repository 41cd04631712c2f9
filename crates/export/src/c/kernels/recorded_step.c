/* The step of an observer whose step is recorded as a whole: advance, which an export defines. */
#include "typical.h"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    NUMBER next[STATES];
    int i;

    advance(t, state->xhat, u, y, next);
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = next[i];
        if (xhat != NULL) {
            xhat[i] = state->xhat[i];
        }
    }
#if TIMED
    ++state->sample;
#endif
}
