/* FreeBSD msun k_sin.c: sin(x + y) on [-pi/4, pi/4], y the tail of x. */
static double lm_k_sin(double x, double y, int tail)
{
    const double s1 = -0x1.5555555555549p-3;
    const double s2 = 0x1.111111110f8a6p-7;
    const double s3 = -0x1.a01a019c161d5p-13;
    const double s4 = 0x1.71de357b1fe7dp-19;
    const double s5 = -0x1.ae5e68a2b9cebp-26;
    const double s6 = 0x1.5d93a5acfd57cp-33;
    const double z = x * x;
    const double w = z * z;
    const double r = s2 + z * (s3 + z * s4) + z * w * (s5 + z * s6);
    const double v = z * x;
    if (tail == 0) {
        return x + v * (s1 + z * r);
    }
    return x - ((z * (0.5 * y - v * r) - y) - v * s1);
}

/* FreeBSD msun k_cos.c. */
static double lm_k_cos(double x, double y)
{
    const double c1 = 0x1.555555555554cp-5;
    const double c2 = -0x1.6c16c16c15177p-10;
    const double c3 = 0x1.a01a019cb159p-16;
    const double c4 = -0x1.27e4f809c52adp-22;
    const double c5 = 0x1.1ee9ebdb4b1c4p-29;
    const double c6 = -0x1.8fae9be8838d4p-37;
    const double z = x * x;
    const double ww = z * z;
    const double r = z * (c1 + z * (c2 + z * c3)) + ww * ww * (c4 + z * (c5 + z * c6));
    const double hz = 0.5 * z;
    const double w = 1.0 - hz;
    return w + (((1.0 - w) - hz) + (z * r - x * y));
}

/* FreeBSD msun k_tan.c: tan(x + y), or -1/tan(x + y) if odd. */
static double lm_k_tan(double argument, double rest, int odd)
{
    static const double t[13] = {
        0x1.5555555555563p-2, 0x1.111111110fe7ap-3, 0x1.ba1ba1bb341fep-5,
        0x1.664f48406d637p-6, 0x1.226e3e96e8493p-7, 0x1.d6d22c9560328p-9,
        0x1.7dbc8fee08315p-10, 0x1.344d8f2f26501p-11, 0x1.026f71a8d1068p-12,
        0x1.47e88a03792a6p-14, 0x1.2b80f32f0a7e9p-14, -0x1.375cbdb605373p-16,
        0x1.b2a7074bf7ad4p-16,
    };
    const double pio4 = 0x1.921fb54442d18p-1;
    const double pio4_lo = 0x1.1a62633145c07p-55;
    double x = argument;
    double y = rest;
    double z;
    double r;
    double v;
    double w;
    double s;
    double w0;
    double a;
    double a0;
    const uint32_t hx = lm_high(x);
    const int negative = (hx >> 31) != 0u;
    const int big = (hx & 0x7fffffffu) >= 0x3fe59428u;
    if (big) {
        if (negative) {
            x = -x;
            y = -y;
        }
        x = (pio4 - x) + (pio4_lo - y);
        y = 0.0;
    }
    z = x * x;
    w = z * z;
    r = t[1] + w * (t[3] + w * (t[5] + w * (t[7] + w * (t[9] + w * t[11]))));
    v = z * (t[2] + w * (t[4] + w * (t[6] + w * (t[8] + w * (t[10] + w * t[12])))));
    s = z * x;
    r = y + z * (s * (r + v) + y) + s * t[0];
    w = x + r;
    if (big) {
        s = 1.0 - 2.0 * (double)odd;
        v = s - 2.0 * (x + (r - w * w / (w + s)));
        return negative ? -v : v;
    }
    if (odd == 0) {
        return w;
    }
    w0 = lm_without_low(w);
    v = r - (w0 - x);
    a = -1.0 / w;
    a0 = lm_without_low(a);
    return a0 + a * (1.0 + a0 * w0 + a0 * v);
}

/* FreeBSD msun s_sin.c. */
static double lm_sin(double x)
{
    const uint32_t ix = lm_high(x) & 0x7fffffffu;
    double y[2];
    int32_t n;
    if (ix <= 0x3fe921fbu) {
        return (ix < 0x3e500000u) ? x : lm_k_sin(x, 0.0, 0);
    }
    if (ix >= 0x7ff00000u) {
        return x - x;
    }
    n = lm_rem_pio2(x, y);
    switch ((uint32_t)n & 3u) {
    case 0u:
        return lm_k_sin(y[0], y[1], 1);
    case 1u:
        return lm_k_cos(y[0], y[1]);
    case 2u:
        return -lm_k_sin(y[0], y[1], 1);
    default:
        return -lm_k_cos(y[0], y[1]);
    }
}

/* FreeBSD msun s_cos.c. */
static double lm_cos(double x)
{
    const uint32_t ix = lm_high(x) & 0x7fffffffu;
    double y[2];
    int32_t n;
    if (ix <= 0x3fe921fbu) {
        return (ix < 0x3e46a09eu) ? 1.0 : lm_k_cos(x, 0.0);
    }
    if (ix >= 0x7ff00000u) {
        return x - x;
    }
    n = lm_rem_pio2(x, y);
    switch ((uint32_t)n & 3u) {
    case 0u:
        return lm_k_cos(y[0], y[1]);
    case 1u:
        return -lm_k_sin(y[0], y[1], 1);
    case 2u:
        return -lm_k_cos(y[0], y[1]);
    default:
        return lm_k_sin(y[0], y[1], 1);
    }
}

/* FreeBSD msun s_tan.c. */
static double lm_tan(double x)
{
    const uint32_t ix = lm_high(x) & 0x7fffffffu;
    double y[2];
    int32_t n;
    if (ix <= 0x3fe921fbu) {
        return (ix < 0x3e400000u) ? x : lm_k_tan(x, 0.0, 0);
    }
    if (ix >= 0x7ff00000u) {
        return x - x;
    }
    n = lm_rem_pio2(x, y);
    return lm_k_tan(y[0], y[1], (int)((uint32_t)n & 1u));
}

/* sin(x + y) on [-pi/4, pi/4], y the tail of x; the polynomial has the relative error 2^-27.9. */
static float lm_k_sinf(float x, float y)
{
    const float s1 = -0x1.555546p-3f;
    const float s2 = 0x1.110778p-7f;
    const float s3 = -0x1.995404p-13f;
    const float z = x * x;
    const float r = s1 + z * (s2 + z * s3);
    return x + (z * (x * r - 0.5f * y) + y);
}

/* cos(x + y) on [-pi/4, pi/4], y the tail of x; the polynomial has the relative error 2^-32.9. */
static float lm_k_cosf(float x, float y)
{
    const float c1 = 0x1.55554ap-5f;
    const float c2 = -0x1.6c0c28p-10f;
    const float c3 = 0x1.99e80cp-16f;
    const float z = x * x;
    const float r = c1 + z * (c2 + z * c3);
    const float hz = 0.5f * z;
    const float w = 1.0f - hz;
    return w + (((1.0f - w) - hz) + (z * (z * r) - x * y));
}

/* tan(x + y) on [-pi/4, pi/4], y the tail of x; the polynomial has the relative error 2^-29.5. */
static float lm_k_tanf(float x, float y)
{
    static const float t[7] = {
        0x1.55556p-2f, 0x1.110d9ep-3f, 0x1.bad9c2p-5f, 0x1.5cc0d4p-6f, 0x1.62cb2ep-7f, 0x1.9bf8a4p-14f, 0x1.1e9266p-8f,
    };
    const float z = x * x;
    const float r = t[0] + z * (t[1] + z * (t[2] + z * (t[3] + z * (t[4] + z * (t[5] + z * t[6])))));
    return x + (z * (x * r + y) + y);
}

/* In binary32 arithmetic alone, as the three below. */
static float lm_sinf(float x)
{
    const uint32_t hx = lm_bitsf(x);
    float y[2] = {0.0f, 0.0f};
    uint32_t n = 0u;
    float r;
    if ((hx & 0x7fffffffu) >= 0x7f800000u) {
        return x - x;
    }
    y[0] = fabsf(x);
    if (y[0] > 0x1.921fb4p-1f) {
        n = lm_rem_pio2f(y[0], y);
    }
    r = ((n & 1u) == 0u) ? lm_k_sinf(y[0], y[1]) : lm_k_cosf(y[0], y[1]);
    return ((n >> 1) == (hx >> 31)) ? r : -r;
}

static float lm_cosf(float x)
{
    float y[2] = {0.0f, 0.0f};
    uint32_t n = 0u;
    float r;
    if ((lm_bitsf(x) & 0x7fffffffu) >= 0x7f800000u) {
        return x - x;
    }
    y[0] = fabsf(x);
    if (y[0] > 0x1.921fb4p-1f) {
        n = lm_rem_pio2f(y[0], y);
    }
    r = ((n & 1u) == 0u) ? lm_k_cosf(y[0], y[1]) : lm_k_sinf(y[0], y[1]);
    return (((n + 1u) & 2u) == 0u) ? r : -r;
}

static float lm_tanf(float x)
{
    const uint32_t hx = lm_bitsf(x);
    float y[2] = {0.0f, 0.0f};
    uint32_t n = 0u;
    float r;
    if ((hx & 0x7fffffffu) >= 0x7f800000u) {
        return x - x;
    }
    y[0] = fabsf(x);
    if (y[0] > 0x1.921fb4p-1f) {
        n = lm_rem_pio2f(y[0], y);
    }
    r = lm_k_tanf(y[0], y[1]);
    if ((n & 1u) != 0u) {
        r = -1.0f / r;
    }
    return ((hx >> 31) == 0u) ? r : -r;
}
