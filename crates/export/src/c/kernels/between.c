/* Numbers within their limits. */
#include "typical.h"

/* The number of [low, high] nearest to x. */
static NUMBER between(NUMBER x, NUMBER low, NUMBER high)
{
    const NUMBER raised = (x > low) ? x : low;
    return (raised < high) ? raised : high;
}
