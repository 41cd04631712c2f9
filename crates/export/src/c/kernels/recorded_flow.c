/* The step of a recorded observer in continuous time. */
#include "recorded_slope.c"
#include "runge_kutta.c"

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
    NUMBER known[INPUTS + OUTPUTS];
    NUMBER z[ORDER + OUTPUTS];
    int i;

    for (i = 0; i < ORDER; ++i) {
        z[i] = state->z[i];
    }
    for (i = 0; i < OUTPUTS; ++i) {
        z[ORDER + i] = y[i];
    }
#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        known[i] = u[i];
    }
#endif
#if HAS_JUMP
    for (i = 0; i < OUTPUTS; ++i) {
        known[INPUTS + i] = y[i];
    }
    jump(t, state->z, known, z);
#endif
    move(t, u, z);
    for (i = 0; i < ORDER; ++i) {
        state->z[i] = z[i];
    }
    for (i = 0; i < OUTPUTS; ++i) {
        known[INPUTS + i] = z[ORDER + i];
    }
    estimate(T_ESTIMATE, z, known, state->xhat);
    if (xhat != NULL) {
        for (i = 0; i < STATES; ++i) {
            xhat[i] = state->xhat[i];
        }
    }
#if TIMED
    ++state->sample;
#endif
}
