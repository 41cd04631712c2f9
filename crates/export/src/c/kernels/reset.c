/* The start of an observer from the first estimate of the design. */
#include "start.c"

void observer_reset(observer_state *state)
{
    observer_init(state, INITIAL);
}
