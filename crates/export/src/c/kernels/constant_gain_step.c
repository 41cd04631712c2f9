/* The step of the copy of a nonlinear plant with a constant gain, which predicts the output between samples. The export
 * defines the slope of (xhat, w), in which w is the predicted output. */
#include "runge_kutta.c"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    NUMBER z[STATES + OUTPUTS];
    int i;

    for (i = 0; i < STATES; ++i) {
        z[i] = state->xhat[i];
    }
    for (i = 0; i < OUTPUTS; ++i) {
        z[STATES + i] = y[i];
    }
    move(t, u, z);
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = z[i];
        if (xhat != NULL) {
            xhat[i] = z[i];
        }
    }
#if TIMED
    ++state->sample;
#endif
}
