/* musl sinh.c: (e + e/(e + 1))/2 with e = exp(|x|) - 1. */
static double lm_sinh(double x)
{
    const double h = ((lm_high(x) >> 31) != 0u) ? -0.5 : 0.5;
    const uint32_t w = lm_high(x) & 0x7fffffffu;
    const double absx = fabs(x);
    if (w < 0x40862e42u) {
        const double t = lm_expm1(absx);
        if (w < 0x3ff00000u) {
            if (w < (0x3ff00000u - (26u << 20))) {
                return x;
            }
            return h * (2.0 * t - t * t / (t + 1.0));
        }
        return h * (t + t / (t + 1.0));
    }
    return 2.0 * h * lm_expo2(absx);
}

/* musl sinhf.c. */
static float lm_sinhf(float x)
{
    const float h = ((lm_bitsf(x) >> 31) != 0u) ? -0.5f : 0.5f;
    const uint32_t w = lm_bitsf(x) & 0x7fffffffu;
    const float absx = fabsf(x);
    if (w < 0x42b17217u) {
        const float t = lm_expm1f(absx);
        if (w < 0x3f800000u) {
            if (w < (0x3f800000u - (12u << 23))) {
                return x;
            }
            return h * (2.0f * t - t * t / (t + 1.0f));
        }
        return h * (t + t / (t + 1.0f));
    }
    return 2.0f * h * lm_expo2f(absx);
}

/* musl cosh.c. */
static double lm_cosh(double argument)
{
    const double x = fabs(argument);
    const uint32_t w = lm_high(x);
    if (w < 0x3fe62e42u) {
        double t;
        if (w < (0x3ff00000u - (26u << 20))) {
            return 1.0;
        }
        t = lm_expm1(x);
        return 1.0 + t * t / (2.0 * (1.0 + t));
    }
    if (w < 0x40862e42u) {
        const double t = lm_exp(x);
        return 0.5 * (t + 1.0 / t);
    }
    return lm_expo2(x);
}

/* musl coshf.c. */
static float lm_coshf(float argument)
{
    const float x = fabsf(argument);
    const uint32_t w = lm_bitsf(x);
    if (w < 0x3f317217u) {
        float t;
        if (w < (0x3f800000u - (12u << 23))) {
            return 1.0f;
        }
        t = lm_expm1f(x);
        return 1.0f + t * t / (2.0f * (1.0f + t));
    }
    if (w < 0x42b17217u) {
        const float t = lm_expf(x);
        return 0.5f * (t + 1.0f / t);
    }
    return lm_expo2f(x);
}

/* musl tanh.c. */
static double lm_tanh(double argument)
{
    const int negative = (lm_high(argument) >> 31) != 0u;
    const double x = fabs(argument);
    const uint32_t w = lm_high(x);
    double t;
    if (w > 0x3fe193eau) {
        if (w > 0x40340000u) {
            t = 1.0 - 0.0 / x;
        } else {
            t = lm_expm1(2.0 * x);
            t = 1.0 - 2.0 / (t + 2.0);
        }
    } else if (w > 0x3fd058aeu) {
        t = lm_expm1(2.0 * x);
        t = t / (t + 2.0);
    } else if (w >= 0x00100000u) {
        t = lm_expm1(-2.0 * x);
        t = -t / (t + 2.0);
    } else {
        t = x;
    }
    return negative ? -t : t;
}

/* musl tanhf.c. */
static float lm_tanhf(float argument)
{
    const int negative = (lm_bitsf(argument) >> 31) != 0u;
    const float x = fabsf(argument);
    const uint32_t w = lm_bitsf(x);
    float t;
    if (w > 0x3f0c9f54u) {
        if (w > 0x41200000u) {
            t = 1.0f + 0.0f / x;
        } else {
            t = lm_expm1f(2.0f * x);
            t = 1.0f - 2.0f / (t + 2.0f);
        }
    } else if (w > 0x3e82c578u) {
        t = lm_expm1f(2.0f * x);
        t = t / (t + 2.0f);
    } else if (w >= 0x00800000u) {
        t = lm_expm1f(-2.0f * x);
        t = -t / (t + 2.0f);
    } else {
        t = x;
    }
    return negative ? -t : t;
}

/* musl asinh.c: log(|x| + sqrt(x^2 + 1)) with the sign of x. */
static double lm_asinh(double argument)
{
    const double ln2 = 0x1.62e42fefa39efp-1;
    const uint32_t e = (lm_high(argument) >> 20) & 0x7ffu;
    const int negative = (lm_high(argument) >> 31) != 0u;
    double x = fabs(argument);
    if (e >= (0x3ffu + 26u)) {
        x = lm_log(x) + ln2;
    } else if (e >= (0x3ffu + 1u)) {
        x = lm_log(2.0 * x + 1.0 / (sqrt(x * x + 1.0) + x));
    } else if (e >= (0x3ffu - 26u)) {
        x = lm_log1p(x + x * x / (sqrt(x * x + 1.0) + 1.0));
    } else {
        /* asinh(x) is x. */
    }
    return negative ? -x : x;
}

/* musl asinhf.c. */
static float lm_asinhf(float argument)
{
    const float ln2 = 0x1.62e43p-1f;
    const uint32_t i = lm_bitsf(argument) & 0x7fffffffu;
    const int negative = (lm_bitsf(argument) >> 31) != 0u;
    float x = fabsf(argument);
    if (i >= (0x3f800000u + (12u << 23))) {
        x = lm_logf(x) + ln2;
    } else if (i >= (0x3f800000u + (1u << 23))) {
        x = lm_logf(2.0f * x + 1.0f / (sqrtf(x * x + 1.0f) + x));
    } else if (i >= (0x3f800000u - (12u << 23))) {
        x = lm_log1pf(x + x * x / (sqrtf(x * x + 1.0f) + 1.0f));
    } else {
        /* asinh(x) is x. */
    }
    return negative ? -x : x;
}

/* musl acosh.c. */
static double lm_acosh(double x)
{
    const double ln2 = 0x1.62e42fefa39efp-1;
    const uint32_t e = (lm_high(x) >> 20) & 0x7ffu;
    if (e < (0x3ffu + 1u)) {
        return lm_log1p(x - 1.0 + sqrt((x - 1.0) * (x - 1.0) + 2.0 * (x - 1.0)));
    }
    if (e < (0x3ffu + 26u)) {
        return lm_log(2.0 * x - 1.0 / (x + sqrt(x * x - 1.0)));
    }
    return lm_log(x) + ln2;
}

/* musl acoshf.c. */
static float lm_acoshf(float x)
{
    const float ln2 = 0x1.62e43p-1f;
    const uint32_t a = lm_bitsf(x) & 0x7fffffffu;
    if (a < (0x3f800000u + (1u << 23))) {
        return lm_log1pf(x - 1.0f + sqrtf((x - 1.0f) * (x - 1.0f) + 2.0f * (x - 1.0f)));
    }
    if (a < (0x3f800000u + (12u << 23))) {
        return lm_logf(2.0f * x - 1.0f / (x + sqrtf(x * x - 1.0f)));
    }
    return lm_logf(x) + ln2;
}

/* musl atanh.c. */
static double lm_atanh(double x)
{
    const uint32_t e = (lm_high(x) >> 20) & 0x7ffu;
    const int negative = (lm_high(x) >> 31) != 0u;
    double y = fabs(x);
    if (e < (0x3ffu - 1u)) {
        if (e >= (0x3ffu - 32u)) {
            y = 0.5 * lm_log1p(2.0 * y + 2.0 * y * y / (1.0 - y));
        }
    } else {
        y = 0.5 * lm_log1p(2.0 * (y / (1.0 - y)));
    }
    return negative ? -y : y;
}

/* musl atanhf.c. */
static float lm_atanhf(float x)
{
    const uint32_t u = lm_bitsf(x) & 0x7fffffffu;
    const int negative = (lm_bitsf(x) >> 31) != 0u;
    float y = fabsf(x);
    if (u < (0x3f800000u - (1u << 23))) {
        if (u >= (0x3f800000u - (32u << 23))) {
            y = 0.5f * lm_log1pf(2.0f * y + 2.0f * y * y / (1.0f - y));
        }
    } else {
        y = 0.5f * lm_log1pf(2.0f * (y / (1.0f - y)));
    }
    return negative ? -y : y;
}
