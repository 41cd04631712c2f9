/* Differences of angles. The export defines TURNS, the full turn of each output that is an angle and 0 for the others,
 * and STATE_TURNS, those of the states. */
#include "typical.h"

/* x less a multiple of the full turn: in (-turn/2, turn/2]. Without a turn x itself. */
static NUMBER wrap(NUMBER x, NUMBER turn)
{
    NUMBER result = x;
    if (turn > REAL(0.0)) {
        result = x + (turn * FLOOR(REAL(0.5) - (x / turn)));
    }
    return result;
}
