/* The part of ESP-IDF's errors that an example of an export uses. */
#include <stdlib.h>

typedef int esp_err_t;

#define ESP_ERROR_CHECK(call) do { if ((call) != 0) { abort(); } } while (0)
