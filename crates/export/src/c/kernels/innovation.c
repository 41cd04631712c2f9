/* The covariance of an innovation, and its factor. */
#ifndef INNOVATION
#define INNOVATION
#include "typical.h"

/* The covariance s = H P H' + V of the innovation, and H P; H stands in all behind h. */
static void spread_of_innovation(const NUMBER *all, const NUMBER *P, const NUMBER *noise, NUMBER *hp, NUMBER *s)
{
    const NUMBER *const H = &all[OUTPUTS];
    int i;
    int j;
    int k;

    for (i = 0; i < OUTPUTS; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = H[i * STATES] * P[j];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (H[(i * STATES) + k] * P[(k * STATES) + j]);
            }
            hp[(i * STATES) + j] = sum;
        }
    }
    for (i = 0; i < OUTPUTS; ++i) {
        for (j = 0; j < OUTPUTS; ++j) {
            NUMBER sum = hp[i * STATES] * H[j * STATES];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (hp[(i * STATES) + k] * H[(j * STATES) + k]);
            }
            s[(i * OUTPUTS) + j] = sum + noise[(i * OUTPUTS) + j];
        }
    }
}

/* The factor g of s = g g' in place of the lower triangle of s; 0 if s is not positive definite in floating point. */
static int factorise(NUMBER s[OUTPUTS][OUTPUTS])
{
    int definite = 1;
    int i;
    int j;
    int k;

    for (j = 0; (j < OUTPUTS) && (definite != 0); ++j) {
        for (i = j; (i < OUTPUTS) && (definite != 0); ++i) {
            NUMBER entry = s[i][j];
            for (k = 0; k < j; ++k) {
                entry = entry - (s[i][k] * s[j][k]);
            }
            if (i > j) {
                s[i][j] = entry / s[j][j];
            } else if (entry > REAL(0.0)) {
                s[j][j] = ROOT(entry);
            } else {
                definite = 0;
            }
        }
    }
    return definite;
}
#endif
