/* The noise of a filter in square-root form: columns are rotated into the factor of its covariance. */
#include "columns.c"
#include "classical.c"

/* The lower triangular factor of the covariance of the noise over a period, along the estimate, by rows in s. */
static void noise(NUMBER t, const NUMBER *xhat, const NUMBER *u, NUMBER *s)
{
    NUMBER x[STATES];
    NUMBER next[STATES];
    NUMBER phi[STATES][STATES];
    NUMBER h[STATES][STATES];
    NUMBER left[STATES][STATES];
    NUMBER total[STATES][STATES];
    NUMBER column[STATES];
    int step;
    int i;
    int j;
    int k;

    for (i = 0; i < STATES; ++i) {
        x[i] = xhat[i];
    }
    for (step = 0; step < SUBSTEPS; ++step) {
        classical(T_STEP, x, u, next, &phi[0][0], &h[0][0]);
        /* The noise of the step by Simpson's rule, W + 4 h W h' + phi W phi', with W = G G' and the weight tau/6. */
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                total[i][j] = ROOT_W[i][j] * NOISE_WEIGHT;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = h[i][0] * ROOT_W[0][j];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (h[i][k] * ROOT_W[k][j]);
                }
                left[i][j] = sum * TWICE_NOISE_WEIGHT;
            }
        }
        for (j = 0; j < STATES; ++j) {
            for (i = 0; i < STATES; ++i) {
                column[i] = left[i][j];
            }
            add(&total[0][0], column, STATES);
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = phi[i][0] * ROOT_W[0][j];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (phi[i][k] * ROOT_W[k][j]);
                }
                left[i][j] = sum * NOISE_WEIGHT;
            }
        }
        for (j = 0; j < STATES; ++j) {
            for (i = 0; i < STATES; ++i) {
                column[i] = left[i][j];
            }
            add(&total[0][0], column, STATES);
        }
#if SEVERAL_STEPS
        if (step > 0) {
            /* The noise of the steps before. */
            for (i = 0; i < STATES; ++i) {
                for (j = 0; j < STATES; ++j) {
                    NUMBER sum = phi[i][0] * s[j];
                    for (k = 1; k < STATES; ++k) {
                        sum = sum + (phi[i][k] * s[(k * STATES) + j]);
                    }
                    left[i][j] = sum;
                }
            }
            for (j = 0; j < STATES; ++j) {
                for (i = 0; i < STATES; ++i) {
                    column[i] = left[i][j];
                }
                add(&total[0][0], column, STATES);
            }
        }
#endif
        for (i = 0; i < STATES; ++i) {
            x[i] = next[i];
            for (j = 0; j < STATES; ++j) {
                s[(i * STATES) + j] = total[i][j];
            }
        }
    }
}
