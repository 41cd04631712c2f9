/* The step of a filter with its functions update and predict, such as the extended Kalman filter. */
#include "kalman.c"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
#if PARTIAL
    int measured = 0;
#endif
    int i;

#if PARTIAL
    for (i = 0; i < OUTPUTS; ++i) {
        if (MAGNITUDE(y[i]) <= LARGEST) {
            measured = 1;
        }
    }
    if (measured != 0) {
        update(state, t, u, y);
    }
#else
    update(state, t, u, y);
#endif
    predict(state, t, u);
    if (xhat != NULL) {
        for (i = 0; i < STATES; ++i) {
            xhat[i] = state->xhat[i];
        }
    }
#if TIMED
    ++state->sample;
#endif
}
