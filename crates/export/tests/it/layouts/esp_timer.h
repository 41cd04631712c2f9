/* The part of ESP-IDF's timers that an example of an export uses, with the time of clock.h. */
#include "clock.h"

typedef struct {
    void (*callback)(void *);
    void *arg;
    const char *name;
} esp_timer_create_args_t;

typedef const esp_timer_create_args_t *esp_timer_handle_t;

static inline int esp_timer_create(const esp_timer_create_args_t *arguments, esp_timer_handle_t *timer)
{
    *timer = arguments;
    return 0;
}

static inline int64_t esp_timer_get_time(void)
{
    return clock_us;
}

/* The first expiry is after one period. */
static inline int esp_timer_start_periodic(esp_timer_handle_t timer, uint64_t period)
{
    int k;

    for (k = 0; k < STEPS; ++k) {
        clock_us = (k + 1) * (int64_t)period + late(k);
        timer->callback(timer->arg);
    }
    return 0;
}

void app_main(void);

int main(void)
{
    app_main();
    return 0;
}
