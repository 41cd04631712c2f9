/* The plant over a period, as the extended Kalman filter and the moving-horizon estimator predict: the next state F(x),
 * the covariance Q of the noise, and the Jacobian A of F, which stand in z one after the other. */
#include "symmetric.c"
#if !DISCRETE
#include "classical.c"
#endif

#if DISCRETE
/* F(x) at the next sample, the covariance Q of the noise, and the Jacobian A of F, in z. */
static void linearise(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *z)
{
    NUMBER all[STATES + (STATES * STATES)];
    int i;
    int j;

    MOTION(t, x, u, all);
    for (i = 0; i < STATES; ++i) {
        z[i] = all[i];
        for (j = 0; j < STATES; ++j) {
            z[STATES + (i * STATES) + j] = W[i][j];
            z[STATES + (STATES * STATES) + (i * STATES) + j] = all[STATES + (i * STATES) + j];
        }
    }
}
#else
/* F(x) at the next sample, the covariance Q of the noise, and the Jacobian A of F, in z. */
static void linearise(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *z)
{
    NUMBER *const Q = &z[STATES];
    NUMBER *const A = &z[STATES + (STATES * STATES)];
    NUMBER next[STATES];
    NUMBER phi[STATES][STATES];
    NUMBER h[STATES][STATES];
    NUMBER left[STATES][STATES];
    NUMBER q[STATES][STATES];
    int step;
    int i;
    int j;
    int k;

    for (i = 0; i < STATES; ++i) {
        z[i] = x[i];
    }
#if SEVERAL_STEPS
    /* The first step writes Q and A without reading them, which compilers may not see. */
    for (i = STATES; i < (STATES + (2 * STATES * STATES)); ++i) {
        z[i] = REAL(0.0);
    }
#endif
    for (step = 0; step < SUBSTEPS; ++step) {
        classical(T_STEP, z, u, next, &phi[0][0], &h[0][0]);
        /* The noise of the step by Simpson's rule: (phi W phi' + 4 h W h' + W) tau/6. */
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = phi[i][0] * W[0][j];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (phi[i][k] * W[k][j]);
                }
                left[i][j] = sum;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = left[i][0] * phi[j][0];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (left[i][k] * phi[j][k]);
                }
                q[i][j] = sum;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = h[i][0] * W[0][j];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (h[i][k] * W[k][j]);
                }
                left[i][j] = sum;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = left[i][0] * h[j][0];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (left[i][k] * h[j][k]);
                }
                q[i][j] = ((q[i][j] + (sum * REAL(4.0))) + W[i][j]) * SIXTH_TAU;
            }
        }
        symmetrise(&q[0][0]);
#if SEVERAL_STEPS
        if (step > 0) {
            /* After the steps before: phi Q phi' + q, and phi A. */
            for (i = 0; i < STATES; ++i) {
                for (j = 0; j < STATES; ++j) {
                    NUMBER sum = phi[i][0] * Q[j];
                    for (k = 1; k < STATES; ++k) {
                        sum = sum + (phi[i][k] * Q[(k * STATES) + j]);
                    }
                    left[i][j] = sum;
                }
            }
            for (i = 0; i < STATES; ++i) {
                for (j = 0; j < STATES; ++j) {
                    NUMBER sum = left[i][0] * phi[j][0];
                    for (k = 1; k < STATES; ++k) {
                        sum = sum + (left[i][k] * phi[j][k]);
                    }
                    q[i][j] = sum + q[i][j];
                }
            }
            symmetrise(&q[0][0]);
            for (i = 0; i < STATES; ++i) {
                for (j = 0; j < STATES; ++j) {
                    NUMBER sum = phi[i][0] * A[j];
                    for (k = 1; k < STATES; ++k) {
                        sum = sum + (phi[i][k] * A[(k * STATES) + j]);
                    }
                    left[i][j] = sum;
                }
            }
            for (i = 0; i < STATES; ++i) {
                for (j = 0; j < STATES; ++j) {
                    phi[i][j] = left[i][j];
                }
            }
        }
#endif
        for (i = 0; i < STATES; ++i) {
            z[i] = next[i];
            for (j = 0; j < STATES; ++j) {
                Q[(i * STATES) + j] = q[i][j];
                A[(i * STATES) + j] = phi[i][j];
            }
        }
    }
}
#endif

/* The covariance next = A P A' + Q, with Q and A in z. */
static void spread(const NUMBER *P, const NUMBER *z, NUMBER *next)
{
    const NUMBER *const Q = &z[STATES];
    const NUMBER *const A = &z[STATES + (STATES * STATES)];
    NUMBER ap[STATES][STATES];
    int i;
    int j;
    int k;

    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = A[i * STATES] * P[j];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (A[(i * STATES) + k] * P[(k * STATES) + j]);
            }
            ap[i][j] = sum;
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = ap[i][0] * A[j * STATES];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (ap[i][k] * A[(j * STATES) + k]);
            }
            next[(i * STATES) + j] = sum + Q[(i * STATES) + j];
        }
    }
    symmetrise(next);
}
