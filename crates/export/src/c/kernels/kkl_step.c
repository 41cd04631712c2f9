/* The step of the numerical KKL observer: its filter over the period, then the estimate. */
#include "kkl.c"
#include "kkl_slope.c"
#include "runge_kutta.c"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    NUMBER offset[OUTPUTS + INPUTS];
    NUMBER v[TARGETS + STATES];
    int i;

    measurement(t, state->xhat, u, offset);
    for (i = 0; i < OUTPUTS; ++i) {
        offset[i] = y[i] - offset[i];
    }
#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        offset[OUTPUTS + i] = u[i];
    }
#endif
    for (i = 0; i < TARGETS; ++i) {
        v[i] = state->z[i];
    }
    for (i = 0; i < STATES; ++i) {
        v[TARGETS + i] = state->xhat[i];
    }
    move(t, offset, v);
    for (i = 0; i < TARGETS; ++i) {
        state->z[i] = v[i];
    }
    left_inverse(state->z, u, state->xhat);
    if (xhat != NULL) {
        for (i = 0; i < STATES; ++i) {
            xhat[i] = state->xhat[i];
        }
    }
#if TIMED
    ++state->sample;
#endif
}
