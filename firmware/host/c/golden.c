/* Runs the golden test of an export on a board, unchanged: the linker calls the functions __wrap_ below in place of
 * main and of the step (--wrap). NAME is the identifier of the observer, and DT the type of the time that the step of an
 * observer at varying periods takes. */
#define DEPTH 65536u
#include "board.h"

#include <stddef.h>
#include <stdio.h>

/* Steps of which the stack is measured. */
#define PAINTED_STEPS 40u

#define JOIN(a, b, c) a##b##c
#define STEP(prefix, name) JOIN(prefix, name, _step)

/* A step without feedback has four arguments; the fifth is on the stack, where nothing looks at it. That at varying
 * periods has a number among them. */
#ifdef DT
#define PARAMETERS void *state, const void *known, const void *y, DT dt, void *first
#define ARGUMENTS state, known, y, dt, first
#define LAST dt
#else
#define PARAMETERS void *state, const void *known, const void *y, void *first, void *second
#define ARGUMENTS state, known, y, first, second
#define LAST second
#endif
typedef void step_function(PARAMETERS);

step_function STEP(__real_, NAME);
step_function STEP(__wrap_, NAME);
int __real_main(void);
int __wrap_main(void);
int _write(int file, const char *text, int length);
void *_sbrk(ptrdiff_t more);
void _exit(int status) __attribute__((noreturn));
int _close(int file);
int _fstat(int file, void *about);
int _isatty(int file);
long _lseek(int file, long offset, int from);
int _read(int file, char *text, int length);
int _kill(int process, int number);
int _getpid(void);

static uint32_t overhead = 0xFFFFFFFFu;
static uint32_t most;
static uint64_t total;
static uint32_t stack;
static uint32_t steps;

static void idle(PARAMETERS)
{
    (void)state;
    (void)known;
    (void)y;
    (void)first;
    (void)LAST;
}

void STEP(__wrap_, NAME)(PARAMETERS)
{
    /* Called through pointers that the optimiser does not see through. */
    step_function *volatile pointers[2] = { idle, STEP(__real_, NAME) };
    step_function *empty = pointers[0];
    step_function *step = pointers[1];
    uint32_t before = COUNT();
    uint32_t count;
    empty(ARGUMENTS);
    count = instructions(before, COUNT());
    overhead = (count < overhead) ? count : overhead;
    if (steps < PAINTED_STEPS) {
        PAINT_STACK();
    }
    before = COUNT();
    step(ARGUMENTS);
    count = instructions(before, COUNT());
    if (steps < PAINTED_STEPS) {
        uint32_t depth;
        PAINTED(depth);
        stack = (depth > stack) ? depth : stack;
    }
    most = (count > most) ? count : most;
    total += count;
    ++steps;
}

int __wrap_main(void)
{
    int wrong;
    start();
    wrong = __real_main();
    printf("costs %lu %lu %lu %lu\n", (unsigned long)(most - overhead),
           (unsigned long)((total - ((uint64_t)overhead * steps) + (steps / 2u)) / steps), (unsigned long)stack,
           (unsigned long)steps);
    fflush(stdout);
    _exit(wrong);
}

/* What the C library needs: an end, the host's terminal, and memory for the buffer of stdout. There are no files. */
void _exit(int status)
{
    call(0x18u, (status == 0) ? 0x20026u : 0x20023u);
    for (;;) {
    }
}

int _write(int file, const char *text, int length)
{
    int i;
    (void)file;
    for (i = 0; i < length; ++i) {
        call(0x03u, (uint32_t)&text[i]);
    }
    return length;
}

int _close(int file)
{
    (void)file;
    return -1;
}

int _fstat(int file, void *about)
{
    (void)file;
    (void)about;
    return -1;
}

int _isatty(int file)
{
    (void)file;
    return 1;
}

long _lseek(int file, long offset, int from)
{
    (void)file;
    (void)offset;
    (void)from;
    return -1;
}

int _read(int file, char *text, int length)
{
    (void)file;
    (void)text;
    (void)length;
    return 0;
}

int _kill(int process, int number)
{
    (void)process;
    (void)number;
    return -1;
}

int _getpid(void)
{
    return 1;
}

void *_sbrk(ptrdiff_t more)
{
    static union {
        double aligned;
        char bytes[16384];
    } heap;
    static size_t used;
    char *start_of_it = &heap.bytes[used];
    if ((more < 0) || ((size_t)more > sizeof heap.bytes - used)) {
        return (void *)-1;
    }
    used += (size_t)more;
    return start_of_it;
}
