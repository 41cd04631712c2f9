/* A Cortex-M on the boards mps2-an385 and mps2-an386: semihosting, a timer, stack. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* Timer 0, of 32 bits: control, value, reload. */
#define TIMER ((volatile uint32_t *)0x40000000u)

#ifndef DEPTH
#define DEPTH 16384u
#endif

#define PAINT 0xA5C396E1u

static void call(uint32_t number, uint32_t argument)
{
    register uint32_t r0 __asm__("r0") = number;
    register uint32_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

static void put(const char *text)
{
    call(0x04u, (uint32_t)text);
}

static void start(void)
{
    TIMER[2] = 0xFFFFFFFFu;
    TIMER[1] = 0xFFFFFFFFu;
    TIMER[0] = 1u;
}

/* QEMU takes 1024 ns for an instruction (-icount shift=10), and the timer counts down every 40 ns. */
static uint32_t instructions(uint32_t before, uint32_t after)
{
    return (uint32_t)(((uint64_t)(before - after) * 40u + 512u) / 1024u);
}

#define COUNT() (TIMER[1])

/* Paints the memory below the stack pointer, and finds the deepest word that is not painted any more. */
#define PAINT_STACK()                                                                                            \
    do {                                                                                                         \
        uint32_t left = DEPTH, at;                                                                               \
        __asm__ volatile(".syntax unified\n mov %0, sp\n 2: subs %0, #4\n str %2, [%0]\n subs %1, #4\n bne 2b"     \
                         : "=&l"(at), "+l"(left) : "l"(PAINT) : "memory", "cc");                                 \
    } while (0)
#define PAINTED(result)                                                                                          \
    do {                                                                                                         \
        uint32_t at, word;                                                                                       \
        result = DEPTH;                                                                                          \
        __asm__ volatile(".syntax unified\n mov %0, sp\n subs %0, %0, %2\n 2: ldr %1, [%0]\n cmp %1, %3\n"         \
                         " bne 3f\n adds %0, #4\n subs %2, #4\n bne 2b\n 3:"                                     \
                         : "=&l"(at), "=&l"(word), "+l"(result) : "l"(PAINT) : "memory", "cc");                  \
    } while (0)

#endif
