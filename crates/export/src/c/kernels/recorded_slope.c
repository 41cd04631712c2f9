/* A recorded observer in continuous time, with an output that is predicted between samples. The export defines its
 * right-hand side rate, its estimate and the jump of its state at a sample, all of them functions of (u, y). */
#include "typical.h"

/* The slopes of the state and of the predicted output, z = (state, w). */
static void slope(NUMBER t, const NUMBER *z, const NUMBER *u, NUMBER *dz)
{
    NUMBER known[INPUTS + OUTPUTS];
    NUMBER xhat[STATES];
    NUMBER f[STATES];
    NUMBER all[OUTPUTS + (OUTPUTS * STATES)];
    int i;
    int j;

#if HAS_INPUTS
    for (i = 0; i < INPUTS; ++i) {
        known[i] = u[i];
    }
#endif
    for (i = 0; i < OUTPUTS; ++i) {
        known[INPUTS + i] = z[ORDER + i];
    }
    estimate(t, z, known, xhat);
    motion(t, xhat, u, f);
    measurement(t, xhat, u, all);
    rate(t, z, known, dz);
    for (i = 0; i < OUTPUTS; ++i) {
        NUMBER sum = all[OUTPUTS + (i * STATES)] * f[0];
        for (j = 1; j < STATES; ++j) {
            sum = sum + (all[OUTPUTS + (i * STATES) + j] * f[j]);
        }
        dz[ORDER + i] = sum;
    }
}
