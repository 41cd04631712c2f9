/* The part of Arduino's core that a sketch of an export uses. The counter has 32 bits, as that of a board, and starts
 * again soon. */
#include <cstdint>
#include <cstdio>

#include "clock.h"

struct Port {
    void begin(long) {}
    void print(double x, int) { std::printf("%.17g", x); }
    void print(int x) { std::printf("%d", x); }
    void print(long x) { std::printf("%ld", x); }
    void print(char c) { std::putchar(c); }
};

static Port Serial;

static unsigned long micros() { return (std::uint32_t)(4294967295LL - 5 + clock_us); }
