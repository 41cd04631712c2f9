/* A polynomial in one variable by Horner's rule, inside the polynomials of a tree. */
#include "typical.h"

/* A polynomial in the first variable; its coefficients begin at leaf[*k], and k is moved behind them. */
static NUMBER horner_1(const NUMBER *leaf, int *k, const NUMBER *local, int degree)
{
    NUMBER sum = REAL(0.0);
    int power;
    for (power = 0; power <= degree; ++power) {
        sum = (sum * local[0]) + leaf[*k];
        *k = *k + 1;
    }
    return sum;
}
