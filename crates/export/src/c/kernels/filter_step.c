/* The step of a filter with its functions update and predict, such as the extended Kalman filter. */
#include "kalman.c"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    int i;

    update(state, t, u, y);
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
