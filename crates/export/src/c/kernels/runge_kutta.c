/* The classical Runge-Kutta method for z' = SLOPE(t, z, u) with LENGTH entries. */
#include "typical.h"

/* One step of the classical Runge-Kutta method. */
static void runge_kutta(NUMBER t, const NUMBER *u, NUMBER *z)
{
    NUMBER k1[LENGTH];
    NUMBER k2[LENGTH];
    NUMBER k3[LENGTH];
    NUMBER k4[LENGTH];
    NUMBER moved[LENGTH];
    int i;

    SLOPE(t, z, u, k1);
    for (i = 0; i < LENGTH; ++i) {
        moved[i] = z[i] + (k1[i] * HALF_TAU);
    }
    SLOPE(T_MIDDLE, moved, u, k2);
    for (i = 0; i < LENGTH; ++i) {
        moved[i] = z[i] + (k2[i] * HALF_TAU);
    }
    SLOPE(T_MIDDLE, moved, u, k3);
    for (i = 0; i < LENGTH; ++i) {
        moved[i] = z[i] + (k3[i] * TAU);
    }
    SLOPE(T_END, moved, u, k4);
    for (i = 0; i < LENGTH; ++i) {
        z[i] = z[i] + (((k1[i] + ((k2[i] + k3[i]) * REAL(2.0))) + k4[i]) * SIXTH_TAU);
    }
}

/* z at the next sample. */
static void move(NUMBER t, const NUMBER *u, NUMBER *z)
{
    int step;
    for (step = 0; step < SUBSTEPS; ++step) {
        runge_kutta(T_STEP, u, z);
    }
}
