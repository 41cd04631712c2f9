/* The part of Zephyr's kernel that a sample of an export uses, with the time of clock.h. As the manual has it, a wait for
 * a timer that has expired since the last one returns at once. */
#include "../clock.h"
#include <stdlib.h>

typedef int64_t k_timeout_t;

struct k_timer {
    k_timeout_t next;
    k_timeout_t period;
    int count;
};

typedef void (*k_timer_expiry_t)(struct k_timer *);

#define K_NO_WAIT ((k_timeout_t)0)
#define K_USEC(t) ((k_timeout_t)(t))
#define CONFIG_SYS_CLOCK_TICKS_PER_SEC 10000

static inline void k_timer_init(struct k_timer *timer, k_timer_expiry_t expired, k_timer_expiry_t stopped)
{
    (void)expired;
    (void)stopped;
    timer->count = 0;
}

static inline void k_timer_start(struct k_timer *timer, k_timeout_t delay, k_timeout_t period)
{
    timer->next = clock_us + delay;
    timer->period = period;
}

static inline uint32_t k_timer_status_sync(struct k_timer *timer)
{
    if (++timer->count == STEPS) {
        exit(0);
    }
    if (timer->next > clock_us) {
        clock_us = timer->next + late(timer->count);
    }
    timer->next += timer->period;
    return 1;
}

static inline int64_t k_uptime_ticks(void)
{
    return clock_us * CONFIG_SYS_CLOCK_TICKS_PER_SEC / 1000000;
}

static inline uint32_t sys_clock_hw_cycles_per_sec(void)
{
    return 64000000;
}

/* The counter starts again soon. */
static inline uint32_t k_cycle_get_32(void)
{
    return (uint32_t)(4294967000LL + 64 * clock_us);
}
