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

#if FILTER_FORM
    advance(t, state->prediction, u, y, state->xhat, next);
#else
    advance(t, state->xhat, u, y, next);
#endif
    for (i = 0; i < STATES; ++i) {
#if FILTER_FORM
        state->prediction[i] = next[i];
#else
        state->xhat[i] = next[i];
#endif
        if (xhat != NULL) {
            xhat[i] = state->xhat[i];
        }
    }
#if TIMED
    ++state->sample;
#endif
}
