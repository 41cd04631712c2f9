/* The feedback u = r - K xhat around the step of an observer. */
#include "typical.h"

void observer_input(const observer_state *state, const NUMBER *r, NUMBER *u)
{
    int i;
    int j;

    for (i = 0; i < INPUTS; ++i) {
        NUMBER sum = K[i][0] * state->xhat[0];
        for (j = 1; j < STATES; ++j) {
            sum = (K[i][j] * state->xhat[j]) + sum;
        }
        u[i] = r[i] - sum;
    }
}

void observer_step(observer_state *state, const NUMBER *r, const NUMBER *y, NUMBER *u, NUMBER *xhat)
{
    NUMBER input[INPUTS];

    observer_input(state, r, input);
    observe(state, input, y, xhat);
    if (u != NULL) {
        int i;
        for (i = 0; i < INPUTS; ++i) {
            u[i] = input[i];
        }
    }
}
