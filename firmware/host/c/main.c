/* A golden program in C, with the inputs and the output of the Rust program. case.h names the observer and its numbers,
 * which are INTEGERS in fixed point. On a board it also prints what the steps cost. */
#include "case.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__arm__)

#include "board.h"

#else

#include <stdio.h>

static void put(const char *text)
{
    fputs(text, stdout);
}

#endif

static void line(uint32_t word)
{
    char text[10];
    int i;
    for (i = 0; i < 8; ++i) {
        text[i] = "0123456789abcdef"[(word >> (28 - 4 * i)) & 15u];
    }
    text[8] = '\n';
    text[9] = '\0';
    put(text);
}

static uint64_t noise = 0x9e3779b97f4a7c15u;

static double next(void)
{
    noise ^= noise >> 12;
    noise ^= noise << 25;
    noise ^= noise >> 27;
    return (double)((noise * 0x2545f4914f6cdd1du) >> 11) * 0x1p-51 - 2.0;
}

static uint32_t digest(const NUMBER *xhat)
{
    const unsigned char *bytes = (const unsigned char *)xhat;
    uint32_t result = 0x811c9dc5u;
    size_t i;
    for (i = 0; i < STATES * sizeof(NUMBER); ++i) {
        result = (result ^ bytes[i]) * 0x01000193u;
    }
    return result;
}

typedef void step_function(STATE *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat);

#if defined(__arm__)
static void idle(STATE *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)
{
    (void)state;
    (void)u;
    (void)y;
    (void)xhat;
}
#endif

#if !defined(INTEGERS)

static int is_finite(const NUMBER *xhat)
{
    int result = 1;
    int i;
    for (i = 0; i < STATES; ++i) {
        result = (result && (xhat[i] - xhat[i] == 0)) ? 1 : 0;
    }
    return result;
}

/* A value of u that is not finite makes the estimate not finite, until the observer is started again; one of y too,
 * unless the observer leaves it out (LEAVES_OUT): then the estimate stays finite. */
static void check_not_finite(void)
{
    const NUMBER bad[3] = { (NUMBER)NAN, (NUMBER)INFINITY, (NUMBER)-INFINITY };
    int place;
    int kind;
    for (place = 0; place < INPUTS + OUTPUTS; ++place) {
        for (kind = 0; kind < 3; ++kind) {
            STATE state;
            NUMBER numbers[INPUTS + OUTPUTS];
            NUMBER xhat[STATES];
            int k;
            RESET(&state);
            for (k = 0; k < 5; ++k) {
                int i;
                for (i = 0; i < INPUTS + OUTPUTS; ++i) {
                    numbers[i] = (NUMBER)0.25;
                }
                if (k == 1) {
                    numbers[place] = bad[kind];
                }
                if (k == 4) {
                    RESET(&state);
                }
                STEP(&state, numbers, &numbers[INPUTS], xhat);
                if (is_finite(xhat) != ((k == 0) || (k == 4) || (LEAVES_OUT && (place >= INPUTS)))) {
                    put("a number that is not finite is not treated as documented\n");
                }
            }
        }
    }
}

#endif

int main(void)
{
    /* Called through pointers that the optimiser does not see through. */
    step_function *volatile step = STEP;
    STATE state;
    NUMBER u[INPUTS + 1];
    NUMBER y[OUTPUTS];
    NUMBER xhat[STATES];
    int i;
    int k;
#if defined(__arm__)
    step_function *volatile nothing = idle;
    uint32_t overhead = 0xFFFFFFFFu;
    uint32_t most = 0;
    uint32_t total = 0;
    uint32_t stack = 0;
    start();
#endif
    RESET(&state);
    put("observer " NAME "\n");
    for (k = 0; k < STEPS; ++k) {
        const double scale = (k % 16 == 7) ? LARGE : SMALL;
        step_function *called = step;
        for (i = 0; i < INPUTS; ++i) {
            u[i] = (NUMBER)(scale * next());
        }
        for (i = 0; i < OUTPUTS; ++i) {
            y[i] = (NUMBER)(scale * next());
        }
#if defined(__arm__)
        {
            step_function *empty = nothing;
            uint32_t before = COUNT();
            uint32_t count;
            uint32_t depth = 0;
            empty(&state, u, y, xhat);
            count = instructions(before, COUNT());
            overhead = (count < overhead) ? count : overhead;
            PAINT_STACK();
            before = COUNT();
            called(&state, u, y, xhat);
            count = instructions(before, COUNT());
            PAINTED(depth);
            stack = (depth > stack) ? depth : stack;
            most = (count > most) ? count : most;
            total += count;
        }
#else
        called(&state, u, y, xhat);
#endif
        line(digest(xhat));
    }
#if !defined(INTEGERS)
    check_not_finite();
#endif
#if defined(__arm__)
    put("overhead, most, total, stack\n");
    line(overhead);
    line(most);
    line(total);
    line(stack);
    call(0x18u, 0x20026u);
#endif
    return 0;
}
