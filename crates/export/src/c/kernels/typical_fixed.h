/* What an export in fixed point defines before its kernel, for a small plant: with this header the kernel compiles
 * on its own. Options are 0 here; a compiler sets them with -D. */
#ifndef TYPICAL_FIXED_H
#define TYPICAL_FIXED_H

#include <stddef.h>
#include <stdint.h>

#define STATES 2
#define INPUTS 1
#define OUTPUTS 1
#ifndef HAS_INPUTS
#define HAS_INPUTS 0
#endif
#ifndef HAS_FEEDTHROUGH
#define HAS_FEEDTHROUGH 0
#endif

/* The gains are their numbers times ONE; a result is from SMALLEST to GREATEST. */
static const int64_t ONE = 65536;
static const int64_t HALF = 32768;
static const int64_t GREATEST = INT32_MAX;
static const int64_t SMALLEST = INT32_MIN;

extern const int32_t A[STATES][STATES];
extern const int32_t B[STATES][INPUTS];
extern const int32_t C[OUTPUTS][STATES];
extern const int32_t L[STATES][OUTPUTS];
extern const int32_t D[OUTPUTS][INPUTS];
extern const int32_t INITIAL[STATES];

typedef struct {
    int32_t xhat[STATES];
    uint32_t saturations;
} observer_state;

void observer_init(observer_state *state, const int32_t *xhat);
void observer_reset(observer_state *state);
void observer_step(observer_state *state, const int32_t *u, const int32_t *y, int32_t *xhat);
void observer_step_partial(observer_state *state, const int32_t *u, const int32_t *y, const uint8_t *measured,
                           int32_t *xhat);

#endif
