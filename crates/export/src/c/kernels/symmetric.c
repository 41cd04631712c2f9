/* The symmetric part of a covariance. */
#ifndef SYMMETRIC
#define SYMMETRIC
#include "typical.h"

/* The symmetric part of P, by rows. */
static void symmetrise(NUMBER *P)
{
    int i;
    int j;
    for (i = 1; i < STATES; ++i) {
        for (j = 0; j < i; ++j) {
            const NUMBER mean = (P[(i * STATES) + j] + P[(j * STATES) + i]) * REAL(0.5);
            P[(i * STATES) + j] = mean;
            P[(j * STATES) + i] = mean;
        }
    }
}
#endif
