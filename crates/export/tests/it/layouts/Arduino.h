/* The part of Arduino's core that a sketch of an export uses; a sample is due at every second call of micros. */
#include <cstdio>

struct Port {
    void begin(long) {}
    void print(double x) { std::printf("%.17g", x); }
    void print(int x) { std::printf("%d", x); }
    void print(long x) { std::printf("%ld", x); }
    void print(char c) { std::putchar(c); }
};

static Port Serial;
static unsigned long now = 4294967295UL - 5UL;

static unsigned long micros() { return now; }
