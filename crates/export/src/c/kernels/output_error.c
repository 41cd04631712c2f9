/* The measured minus the expected output, a variable of a functional mock-up unit; output_error is recorded. */
#include "typical.h"

void observer_innovation(const observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *innovation)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif
#if FILTER_FORM
    output_error(t, state->prediction, u, y, innovation);
#else
    output_error(t, state->xhat, u, y, innovation);
#endif
}
