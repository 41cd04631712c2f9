/* The start of a recorded observer: its state z from the first estimate and the output that it predicts. */
#include "typical.h"

void observer_init(observer_state *state, const NUMBER *xhat)
{
#if STARTS_WITH_OUTPUT
#if HAS_INPUTS
    const NUMBER u[INPUTS] = { REAL(0.0) };
#else
    const NUMBER *const u = NULL;
#endif
    NUMBER all[OUTPUTS + (OUTPUTS * STATES)];
#endif
    int i;

#if STARTS_WITH_OUTPUT
    measurement(REAL(0.0), xhat, u, all);
    start(REAL(0.0), xhat, all, state->z);
#else
    start(REAL(0.0), xhat, NULL, state->z);
#endif
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = xhat[i];
    }
#if TIMED
    state->sample = 0;
#endif
}
