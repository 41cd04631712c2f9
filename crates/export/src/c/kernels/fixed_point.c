/* A linear observer in fixed point: sums are accumulated in 64 bits without rounding, and rounded once. */
#include "typical_fixed.h"

/* The integer nearest to sum / ONE, ties upwards, within the range. Shifts of negative integers differ from compiler to
 * compiler, divisions do not. */
static int32_t rounded(int64_t sum, uint32_t *saturations)
{
    const int64_t above = sum + HALF;
    int64_t result = above / ONE;

    if ((above % ONE) < 0) {
        result = result - 1;
    }
    if ((result > GREATEST) || (result < SMALLEST)) {
        result = (result > GREATEST) ? GREATEST : SMALLEST;
        if (*saturations < UINT32_MAX) {
            *saturations = *saturations + 1u;
        }
    }
    return (int32_t)result;
}

void observer_init(observer_state *state, const int32_t *xhat)
{
    int i;
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = xhat[i];
    }
    state->saturations = 0u;
}

void observer_reset(observer_state *state)
{
    observer_init(state, INITIAL);
}

void observer_step_partial(observer_state *state, const int32_t *u, const int32_t *y, const uint8_t *measured,
                           int32_t *xhat)
{
    int32_t innovation[OUTPUTS];
    int32_t next[STATES];
    int i;
    int j;

#if !HAS_INPUTS
    (void)u;
#endif
    for (i = 0; i < OUTPUTS; ++i) {
        innovation[i] = 0;
        if ((measured == NULL) || (measured[i] != 0u)) {
            int64_t sum = (int64_t)y[i] * ONE;
            for (j = 0; j < STATES; ++j) {
                sum = sum - ((int64_t)C[i][j] * (int64_t)state->xhat[j]);
            }
#if HAS_FEEDTHROUGH
            for (j = 0; j < INPUTS; ++j) {
                sum = sum - ((int64_t)D[i][j] * (int64_t)u[j]);
            }
#endif
            innovation[i] = rounded(sum, &state->saturations);
        }
    }
    for (i = 0; i < STATES; ++i) {
        int64_t sum = 0;
        for (j = 0; j < STATES; ++j) {
            sum = sum + ((int64_t)A[i][j] * (int64_t)state->xhat[j]);
        }
#if HAS_INPUTS
        for (j = 0; j < INPUTS; ++j) {
            sum = sum + ((int64_t)B[i][j] * (int64_t)u[j]);
        }
#endif
        for (j = 0; j < OUTPUTS; ++j) {
            sum = sum + ((int64_t)L[i][j] * (int64_t)innovation[j]);
        }
        next[i] = rounded(sum, &state->saturations);
    }
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = next[i];
        if (xhat != NULL) {
            xhat[i] = next[i];
        }
    }
}

void observer_step(observer_state *state, const int32_t *u, const int32_t *y, int32_t *xhat)
{
    observer_step_partial(state, u, y, NULL, xhat);
}
