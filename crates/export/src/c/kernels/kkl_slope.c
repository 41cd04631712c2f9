/* What the numerical KKL observer integrates between samples. */
#include "typical.h"

/* The slopes of the target states and of the copy of the plant, v = (z, x); offset + h(x) is the predicted output. Held
 * inputs follow the offset. */
static void slope(NUMBER t, const NUMBER *v, const NUMBER *offset, NUMBER *dv)
{
    NUMBER w[OUTPUTS];
    int i;
    int j;

    measurement(t, &v[TARGETS], &offset[OUTPUTS], w);
    motion(t, &v[TARGETS], &offset[OUTPUTS], &dv[TARGETS]);
    for (i = 0; i < OUTPUTS; ++i) {
        w[i] = offset[i] + w[i];
    }
    for (i = 0; i < TARGETS; ++i) {
        NUMBER sum = FILTER[i][0] * v[0];
        for (j = 1; j < TARGETS; ++j) {
            sum = (FILTER[i][j] * v[j]) + sum;
        }
        dv[i] = sum;
    }
    for (i = 0; i < TARGETS; ++i) {
        NUMBER sum = B[i][0] * w[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (B[i][j] * w[j]) + sum;
        }
        dv[i] = dv[i] + sum;
    }
}
