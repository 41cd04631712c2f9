/* Unit vectors among the states, as quaternions. The export defines UNIT_VECTORS, the number of the unit vector of each
 * state from 1 to VECTORS, and 0 for the others. */
#include "symmetric.c"

/* Row i of a covariance times T', T = (I - q q')/|q| for the entries of q, those of a unit vector. */
static void project_row(NUMBER *P, int row, int step, const NUMBER *x, NUMBER norm, int vector)
{
    NUMBER along = REAL(0.0);
    int j;
    for (j = 0; j < STATES; ++j) {
        if ((int)UNIT_VECTORS[0][j] == vector) {
            along = along + (P[row + (j * step)] * x[j]);
        }
    }
    for (j = 0; j < STATES; ++j) {
        if ((int)UNIT_VECTORS[0][j] == vector) {
            P[row + (j * step)] = (P[row + (j * step)] - (along * x[j])) / norm;
        }
    }
}

/* Divides the unit vectors of the estimate by their norms: q <- q/|q|, P <- T P T'. A norm that is 0 or not finite leaves
 * its vector as it is, and a result that is not finite the estimate. */
static void normalise(observer_state *state)
{
    NUMBER x[STATES];
    NUMBER P[STATES][STATES];
    int finite = 1;
    int vector;
    int i;
    int j;

    for (i = 0; i < STATES; ++i) {
        x[i] = state->xhat[i];
        for (j = 0; j < STATES; ++j) {
            P[i][j] = state->P[i][j];
        }
    }
    for (vector = 1; vector <= VECTORS; ++vector) {
        NUMBER norm = REAL(0.0);
        for (i = 0; i < STATES; ++i) {
            if ((int)UNIT_VECTORS[0][i] == vector) {
                norm = norm + (x[i] * x[i]);
            }
        }
        norm = ROOT(norm);
        if ((norm > REAL(0.0)) && (norm <= LARGEST)) {
            for (i = 0; i < STATES; ++i) {
                if ((int)UNIT_VECTORS[0][i] == vector) {
                    x[i] = x[i] / norm;
                }
            }
            for (j = 0; j < STATES; ++j) {
                project_row(&P[0][0], j, STATES, x, norm, vector);
            }
            for (i = 0; i < STATES; ++i) {
                project_row(&P[0][0], i * STATES, 1, x, norm, vector);
            }
        }
    }
    symmetrise(&P[0][0]);
    for (i = 0; i < STATES; ++i) {
        if (!(MAGNITUDE(x[i]) <= LARGEST)) {
            finite = 0;
        }
        for (j = 0; j < STATES; ++j) {
            if (!(MAGNITUDE(P[i][j]) <= LARGEST)) {
                finite = 0;
            }
        }
    }
    for (i = 0; (i < STATES) && (finite != 0); ++i) {
        state->xhat[i] = x[i];
        for (j = 0; j < STATES; ++j) {
            state->P[i][j] = P[i][j];
        }
    }
}
