/* The flow of the cubic part of a sampled cubic observer whose gain is not radial, in one semi-implicit step. */
#include "typical.h"

/* The cubic part for the time dt in a semi-implicit step: (I + s G) r = y~ with s = dt y~'theta y~ and G = -C N, by
 * elimination with row exchanges; y~ becomes r, the impulse is s r. s is bounded, so that nothing overflows. */
static void flow(NUMBER *innovation, NUMBER *impulse, NUMBER dt)
{
    NUMBER matrix[OUTPUTS][OUTPUTS];
    NUMBER weighted[OUTPUTS];
    NUMBER size = REAL(0.0);
    NUMBER q;
    NUMBER s;
    int solved = 1;
    int i;
    int j;
    int k;

    for (i = 0; i < OUTPUTS; ++i) {
        const NUMBER entry = MAGNITUDE(innovation[i]);
        size = (entry > size) ? entry : size;
        impulse[i] = innovation[i];
    }
    if (size > REAL(0.0)) {
        for (i = 0; i < OUTPUTS; ++i) {
            impulse[i] = impulse[i] / size;
        }
    }
    for (i = 0; i < OUTPUTS; ++i) {
        NUMBER sum = THETA[i][0] * impulse[0];
        for (j = 1; j < OUTPUTS; ++j) {
            sum = (THETA[i][j] * impulse[j]) + sum;
        }
        weighted[i] = sum;
    }
    q = impulse[0] * weighted[0];
    for (i = 1; i < OUTPUTS; ++i) {
        q = q + (impulse[i] * weighted[i]);
    }
    q = (q > REAL(0.0)) ? q : REAL(0.0);
    s = q * dt * size * size;
    s = (s < MOST_PULL) ? s : MOST_PULL;
    for (i = 0; i < OUTPUTS; ++i) {
        impulse[i] = innovation[i];
        for (j = 0; j < OUTPUTS; ++j) {
            matrix[i][j] = s * G[i][j];
        }
        matrix[i][i] = REAL(1.0) + matrix[i][i];
    }
    for (k = 0; (k < OUTPUTS) && (solved == 1); ++k) {
        int best = k;
        for (i = k + 1; i < OUTPUTS; ++i) {
            if (MAGNITUDE(matrix[i][k]) > MAGNITUDE(matrix[best][k])) {
                best = i;
            }
        }
        if (!(MAGNITUDE(matrix[best][k]) > REAL(0.0))) {
            solved = 0;
        }
        if ((solved == 1) && (best != k)) {
            const NUMBER entry = impulse[best];
            impulse[best] = impulse[k];
            impulse[k] = entry;
            for (j = k; j < OUTPUTS; ++j) {
                const NUMBER other = matrix[best][j];
                matrix[best][j] = matrix[k][j];
                matrix[k][j] = other;
            }
        }
        for (i = k + 1; (i < OUTPUTS) && (solved == 1); ++i) {
            const NUMBER factor = matrix[i][k] / matrix[k][k];
            for (j = k + 1; j < OUTPUTS; ++j) {
                matrix[i][j] = matrix[i][j] - (factor * matrix[k][j]);
            }
            impulse[i] = impulse[i] - (factor * impulse[k]);
        }
    }
    for (i = OUTPUTS - 1; (i >= 0) && (solved == 1); --i) {
        NUMBER rest = impulse[i];
        for (j = i + 1; j < OUTPUTS; ++j) {
            rest = rest - (matrix[i][j] * impulse[j]);
        }
        impulse[i] = rest / matrix[i][i];
    }
    for (i = 0; i < OUTPUTS; ++i) {
        if (solved == 1) {
            innovation[i] = impulse[i];
            impulse[i] = impulse[i] * s;
        } else {
            impulse[i] = REAL(0.0);
        }
    }
}
