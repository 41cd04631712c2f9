/* A polynomial in one variable more than INNER has, by Horner's rule. */
#include "horner.c"

/* The same in one variable more, which is outside: the degree that it leaves for those inside grows. */
static NUMBER HORNER(const NUMBER *leaf, int *k, const NUMBER *local, int degree)
{
    NUMBER sum = REAL(0.0);
    int power;
    for (power = 0; power <= degree; ++power) {
        sum = (sum * local[VARIABLE]) + INNER(leaf, k, local, power);
    }
    return sum;
}
