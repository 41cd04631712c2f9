/* The classical Runge-Kutta method with Jacobians, of filters of plants in continuous time. */
#include "typical.h"

/* One step of the classical Runge-Kutta method: the next state, its Jacobian phi, and the Jacobian h from the middle of
 * the step to its end, by rows. */
static void classical(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *next, NUMBER *phi, NUMBER *h)
{
    NUMBER f1[STATES + (STATES * STATES)];
    NUMBER f2[STATES + (STATES * STATES)];
    NUMBER f3[STATES + (STATES * STATES)];
    NUMBER f4[STATES + (STATES * STATES)];
    NUMBER point[STATES];
    NUMBER m2[STATES][STATES];
    NUMBER m3[STATES][STATES];
    NUMBER m4[STATES][STATES];
    int i;
    int j;
    int k;

    MOTION(t, x, u, f1);
    for (i = 0; i < STATES; ++i) {
        point[i] = x[i] + (f1[i] * HALF_TAU);
    }
    MOTION(T_MIDDLE, point, u, f2);
    for (i = 0; i < STATES; ++i) {
        point[i] = x[i] + (f2[i] * HALF_TAU);
    }
    MOTION(T_MIDDLE, point, u, f3);
    for (i = 0; i < STATES; ++i) {
        point[i] = x[i] + (f3[i] * TAU);
    }
    MOTION(T_END, point, u, f4);
    for (i = 0; i < STATES; ++i) {
        next[i] = x[i] + (((f1[i] + ((f2[i] + f3[i]) * REAL(2.0))) + f4[i]) * SIXTH_TAU);
    }
    /* The derivatives of the slopes by x. */
    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = f2[STATES + (i * STATES)] * f1[STATES + j];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (f2[STATES + (i * STATES) + k] * f1[STATES + (k * STATES) + j]);
            }
            m2[i][j] = f2[STATES + (i * STATES) + j] + (sum * HALF_TAU);
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = f3[STATES + (i * STATES)] * m2[0][j];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (f3[STATES + (i * STATES) + k] * m2[k][j]);
            }
            m3[i][j] = f3[STATES + (i * STATES) + j] + (sum * HALF_TAU);
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = f4[STATES + (i * STATES)] * m3[0][j];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (f4[STATES + (i * STATES) + k] * m3[k][j]);
            }
            m4[i][j] = f4[STATES + (i * STATES) + j] + (sum * TAU);
        }
    }
    /* h = I + a (I + a (I + a/3)/2) for a = (tau/2) Df from the middle to the end: a in m2, the brackets in m3, m4. */
    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            const NUMBER identity = (i == j) ? REAL(1.0) : REAL(0.0);
            const int entry = STATES + (i * STATES) + j;
            phi[(i * STATES) + j] =
                identity + (((f1[entry] + ((m2[i][j] + m3[i][j]) * REAL(2.0))) + m4[i][j]) * SIXTH_TAU);
            m2[i][j] = (f3[entry] + f4[entry]) * QUARTER_TAU;
            m3[i][j] = identity + (m2[i][j] * THIRD);
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = m2[i][0] * m3[0][j];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (m2[i][k] * m3[k][j]);
            }
            m4[i][j] = ((i == j) ? REAL(1.0) : REAL(0.0)) + (sum * REAL(0.5));
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (j = 0; j < STATES; ++j) {
            NUMBER sum = m2[i][0] * m4[0][j];
            for (k = 1; k < STATES; ++k) {
                sum = sum + (m2[i][k] * m4[k][j]);
            }
            h[(i * STATES) + j] = ((i == j) ? REAL(1.0) : REAL(0.0)) + sum;
        }
    }
}
