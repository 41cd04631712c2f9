/* The bits of a number, and numbers made of bits. */
static uint64_t lm_bits(double x)
{
    uint64_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

static double lm_from_bits(uint64_t bits)
{
    double x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

static uint32_t lm_high(double x)
{
    return (uint32_t)(lm_bits(x) >> 32);
}

static uint32_t lm_low(double x)
{
    return (uint32_t)(lm_bits(x) & 0xffffffffu);
}

static double lm_with_high(double x, uint32_t high)
{
    return lm_from_bits(((uint64_t)high << 32) | (lm_bits(x) & 0xffffffffu));
}

static double lm_without_low(double x)
{
    return lm_from_bits((lm_bits(x) >> 32) << 32);
}

static uint32_t lm_bitsf(float x)
{
    uint32_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

static float lm_from_bitsf(uint32_t bits)
{
    float x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

/* x 2^n, rounded once. */
static double lm_scalbn(double x, int32_t n)
{
    double y = x;
    int32_t k = n;
    if (k > 1023) {
        y *= 0x1p+1023;
        k -= 1023;
        if (k > 1023) {
            y *= 0x1p+1023;
            k -= 1023;
            if (k > 1023) {
                k = 1023;
            }
        }
    } else if (k < -1022) {
        y *= 0x1p-969;
        k += 969;
        if (k < -1022) {
            y *= 0x1p-969;
            k += 969;
            if (k < -1022) {
                k = -1022;
            }
        }
    } else {
        /* In range. */
    }
    return y * lm_from_bits((uint64_t)(uint32_t)(1023 + k) << 52);
}

static float lm_scalbnf(float x, int32_t n)
{
    float y = x;
    int32_t k = n;
    if (k > 127) {
        y *= 0x1p+127f;
        k -= 127;
        if (k > 127) {
            y *= 0x1p+127f;
            k -= 127;
            if (k > 127) {
                k = 127;
            }
        }
    } else if (k < -126) {
        y *= 0x1p-102f;
        k += 102;
        if (k < -126) {
            y *= 0x1p-102f;
            k += 102;
            if (k < -126) {
                k = -126;
            }
        }
    } else {
        /* In range. */
    }
    return y * lm_from_bitsf((uint32_t)(127 + k) << 23);
}
