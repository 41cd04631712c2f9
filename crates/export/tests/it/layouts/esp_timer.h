/* The part of ESP-IDF's timers that an example of an export uses; the timer expires three times. */
#include <stdint.h>
#include <stdio.h>

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

static inline int esp_timer_start_periodic(esp_timer_handle_t timer, uint64_t period)
{
    int k;

    for (k = 0; k < 3; ++k) {
        timer->callback(timer->arg);
        printf("%llu us\n", (unsigned long long)period);
    }
    return 0;
}

void app_main(void);

int main(void)
{
    app_main();
    return 0;
}
