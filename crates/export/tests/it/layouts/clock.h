/* The clock of a test, what its program measures and applies, and what it prints. PERIOD is in microseconds; a program is
 * woken up to a third of a period late. */
#ifndef CLOCK_H
#define CLOCK_H
#include <stdint.h>
#include <stdio.h>

enum { STEPS = 12 };

static int64_t clock_us;

static inline int64_t late(int k)
{
    return (29 * k % 17) * (PERIOD / 50);
}

/* Numbers without pattern, exact in any format. */
static inline double measured(void)
{
    static int k;
    return (double)((37 * k++ + 11) % 64) / 32.0 - 1.0;
}

static inline double input(void)
{
    static int k;
    return (double)((53 * k++ + 5) % 64) / 32.0 - 1.0;
}

#define REPORT(xhat)                                                             \
    do {                                                                         \
        printf("%lld", (long long)clock_us);                                     \
        for (unsigned i = 0; i < sizeof (xhat) / sizeof (xhat)[0]; ++i) {        \
            printf(" %.17g", (double)(xhat)[i]);                                 \
        }                                                                        \
        printf("\n");                                                            \
    } while (0)
#endif
