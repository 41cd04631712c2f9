/* The step of a filter with its functions update and predict, such as the extended Kalman filter. */
#include "kalman.c"

/* The update by the outputs that were measured; nothing without any. */
static void take(observer_state *state, NUMBER t, const NUMBER *u, const NUMBER *y)
{
#if PARTIAL
    int measured = 0;
    int i;

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
}

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    int i;

    take(state, t, u, y);
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
