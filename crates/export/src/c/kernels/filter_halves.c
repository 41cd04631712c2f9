/* Update and prediction of a filter, apart from its step. */
#include "filter_step.c"

void observer_update(observer_state *state, const NUMBER *u, const NUMBER *y)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif

    take(state, t, u, y);
}

void observer_predict(observer_state *state, const NUMBER *u)
{
#if TIMED
    const NUMBER t = (NUMBER)state->sample * PERIOD;
#else
    const NUMBER t = REAL(0.0);
#endif

    predict(state, t, u);
#if TIMED
    ++state->sample;
#endif
}
