/* The copy of a nonlinear plant with a constant gain, which predicts the output between samples. */
#include "typical.h"

/* The slopes of the estimate and of the predicted output, z = (xhat, w). */
static void slope(NUMBER t, const NUMBER *z, const NUMBER *u, NUMBER *dz)
{
    NUMBER all[OUTPUTS + (OUTPUTS * STATES)];
    NUMBER innovation[OUTPUTS];
    int i;
    int j;

    motion(t, z, u, dz);
    measurement(t, z, u, all);
    for (i = 0; i < OUTPUTS; ++i) {
        NUMBER sum = all[OUTPUTS + (i * STATES)] * dz[0];
        for (j = 1; j < STATES; ++j) {
            sum = sum + (all[OUTPUTS + (i * STATES) + j] * dz[j]);
        }
        dz[STATES + i] = sum;
        innovation[i] = z[STATES + i] - all[i];
    }
    for (i = 0; i < STATES; ++i) {
        NUMBER sum = L[i][0] * innovation[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = sum + (L[i][j] * innovation[j]);
        }
        dz[i] = dz[i] + sum;
    }
}
