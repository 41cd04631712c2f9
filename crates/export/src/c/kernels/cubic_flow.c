/* The flow of the cubic part of a sampled cubic observer, in closed form. */
#include "typical.h"

/* The cubic part for the time dt in closed form: y~ becomes y~/sqrt(1 + 2 w dt y~'theta y~). Squares are not formed, so
 * that nothing overflows. */
static void flow(NUMBER *innovation, NUMBER *impulse, NUMBER dt)
{
    NUMBER size = REAL(0.0);
    int i;

    for (i = 0; i < OUTPUTS; ++i) {
        const NUMBER entry = MAGNITUDE(innovation[i]);
        size = (entry > size) ? entry : size;
    }
    if (size <= REAL(0.0)) {
        for (i = 0; i < OUTPUTS; ++i) {
            impulse[i] = innovation[i];
        }
    } else {
        NUMBER direction[OUTPUTS];
        NUMBER weighted[OUTPUTS];
        NUMBER q;
        NUMBER drive;
        NUMBER radical;
        NUMBER reach;
        NUMBER left;
        NUMBER right;
        NUMBER pull;
        int j;

        for (i = 0; i < OUTPUTS; ++i) {
            direction[i] = innovation[i] / size;
        }
        for (i = 0; i < OUTPUTS; ++i) {
            NUMBER sum = THETA[i][0] * direction[0];
            for (j = 1; j < OUTPUTS; ++j) {
                sum = (THETA[i][j] * direction[j]) + sum;
            }
            weighted[i] = sum;
        }
        q = direction[0] * weighted[0];
        for (i = 1; i < OUTPUTS; ++i) {
            q = q + (direction[i] * weighted[i]);
        }
        q = (q > REAL(0.0)) ? q : REAL(0.0);
        drive = REAL(2.0) * q * dt;
        radical = (CUBIC_RATE > REAL(0.0)) ? ROOT(CUBIC_RATE * drive) : REAL(0.0);
        reach = radical * size;
        if (reach <= LARGE_REACH) {
            const NUMBER hypotenuse = ROOT(REAL(1.0) + (reach * reach));
            left = size / hypotenuse;
            right = size / (REAL(1.0) + hypotenuse);
        } else {
            left = REAL(1.0) / radical;
            right = REAL(1.0) / radical;
        }
        pull = drive * left * right * size;
        pull = (pull < MOST_PULL) ? pull : MOST_PULL;
        for (i = 0; i < OUTPUTS; ++i) {
            innovation[i] = direction[i] * left;
            impulse[i] = direction[i] * pull;
        }
    }
}
