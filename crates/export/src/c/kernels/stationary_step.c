/* The step of a stationary Kalman filter by its halves: the export defines the innovation, the update and the prediction
 * for it. */
#include "typical.h"

void observer_update(observer_state *state, const NUMBER *u, const NUMBER *y)
{
    NUMBER innovation[OUTPUTS];
    int i;

    innovate(REAL(0.0), state->prediction, u, y, state->innovation, innovation);
    for (i = 0; i < OUTPUTS; ++i) {
        state->innovation[i] = innovation[i];
    }
    updated(REAL(0.0), state->prediction, state->innovation, state->xhat);
}

void observer_predict(observer_state *state, const NUMBER *u)
{
    NUMBER next[STATES];
    int i;

    advance(REAL(0.0), state->prediction, u, state->innovation, next);
    for (i = 0; i < STATES; ++i) {
        state->prediction[i] = next[i];
    }
    for (i = 0; i < OUTPUTS; ++i) {
        state->innovation[i] = REAL(0.0);
    }
}

void observer_step(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
    int i;

    observer_update(state, u, y);
    observer_predict(state, u);
    if (xhat != NULL) {
        for (i = 0; i < STATES; ++i) {
            xhat[i] = state->xhat[i];
        }
    }
}
