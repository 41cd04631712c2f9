/* The part of Zephyr's kernel that a sample of an export uses; the timer expires three times. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef int64_t k_timeout_t;

struct k_timer {
    k_timeout_t period;
    int count;
};

typedef void (*k_timer_expiry_t)(struct k_timer *);

#define K_NO_WAIT ((k_timeout_t)0)
#define K_USEC(t) ((k_timeout_t)(t))

static inline void k_timer_init(struct k_timer *timer, k_timer_expiry_t expired, k_timer_expiry_t stopped)
{
    (void)expired;
    (void)stopped;
    timer->count = 0;
}

static inline void k_timer_start(struct k_timer *timer, k_timeout_t delay, k_timeout_t period)
{
    (void)delay;
    timer->period = period;
}

static inline uint32_t k_timer_status_sync(struct k_timer *timer)
{
    printf("%lld us\n", (long long)timer->period);
    if (++timer->count == 3) {
        exit(0);
    }
    return 1;
}
