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

/* FreeBSD msun k_sinf.c. */
static float lm_k_sinf(double x)
{
    const double s1 = -0x1.5555554cbac77p-3;
    const double s2 = 0x1.11110896efbb2p-7;
    const double s3 = -0x1.a00f9e2cae774p-13;
    const double s4 = 0x1.6cd878c3b46a7p-19;
    const double z = x * x;
    const double w = z * z;
    const double r = s3 + z * s4;
    const double s = z * x;
    return (float)((x + s * (s1 + z * s2)) + s * w * r);
}

/* FreeBSD msun k_cosf.c. */
static float lm_k_cosf(double x)
{
    const double c0 = -0x1.ffffffd0c5e81p-2;
    const double c1 = 0x1.55553e1053a42p-5;
    const double c2 = -0x1.6c087e80f1e27p-10;
    const double c3 = 0x1.99342e0ee5069p-16;
    const double z = x * x;
    const double w = z * z;
    const double r = c2 + z * c3;
    return (float)(((1.0 + z * c0) + w * c1) + (w * z) * r);
}

/* FreeBSD msun k_tanf.c. */
static float lm_k_tanf(double x, int odd)
{
    static const double t[6] = {
        0x1.5554d3418c99fp-2, 0x1.112fd38999f72p-3, 0x1.b54c91d865afep-5,
        0x1.91df3908c33cep-6, 0x1.85dadfcecf44ep-9, 0x1.362b9bf971bcdp-7,
    };
    const double z = x * x;
    const double rr = t[4] + z * t[5];
    const double tt = t[2] + z * t[3];
    const double w = z * z;
    const double s = z * x;
    const double u = t[0] + z * t[1];
    const double r = (x + s * u) + (s * w) * (tt + w * rr);
    return (float)((odd != 0) ? (-1.0 / r) : r);
}

/* FreeBSD msun s_sinf.c. */
static float lm_sinf(float x)
{
    const double pio2 = 0x1.921fb54442d18p+0;
    const double x64 = (double)x;
    const uint32_t ix = lm_bitsf(x) & 0x7fffffffu;
    const int negative = (lm_bitsf(x) >> 31) != 0u;
    double y;
    int32_t n;
    if (ix <= 0x3f490fdau) {
        return (ix < 0x39800000u) ? x : lm_k_sinf(x64);
    }
    if (ix <= 0x407b53d1u) {
        if (ix <= 0x4016cbe3u) {
            return negative ? -lm_k_cosf(x64 + 1.0 * pio2) : lm_k_cosf(x64 - 1.0 * pio2);
        }
        return lm_k_sinf(negative ? -(x64 + 2.0 * pio2) : -(x64 - 2.0 * pio2));
    }
    if (ix <= 0x40e231d5u) {
        if (ix <= 0x40afeddfu) {
            return negative ? lm_k_cosf(x64 + 3.0 * pio2) : -lm_k_cosf(x64 - 3.0 * pio2);
        }
        return lm_k_sinf(negative ? (x64 + 4.0 * pio2) : (x64 - 4.0 * pio2));
    }
    if (ix >= 0x7f800000u) {
        return x - x;
    }
    n = lm_rem_pio2f(x, &y);
    switch ((uint32_t)n & 3u) {
    case 0u:
        return lm_k_sinf(y);
    case 1u:
        return lm_k_cosf(y);
    case 2u:
        return lm_k_sinf(-y);
    default:
        return -lm_k_cosf(y);
    }
}

/* FreeBSD msun s_cosf.c. */
static float lm_cosf(float x)
{
    const double pio2 = 0x1.921fb54442d18p+0;
    const double x64 = (double)x;
    const uint32_t ix = lm_bitsf(x) & 0x7fffffffu;
    const int negative = (lm_bitsf(x) >> 31) != 0u;
    double y;
    int32_t n;
    if (ix <= 0x3f490fdau) {
        return (ix < 0x39800000u) ? 1.0f : lm_k_cosf(x64);
    }
    if (ix <= 0x407b53d1u) {
        if (ix > 0x4016cbe3u) {
            return -lm_k_cosf(negative ? (x64 + 2.0 * pio2) : (x64 - 2.0 * pio2));
        }
        return lm_k_sinf(negative ? (x64 + 1.0 * pio2) : (1.0 * pio2 - x64));
    }
    if (ix <= 0x40e231d5u) {
        if (ix > 0x40afeddfu) {
            return lm_k_cosf(negative ? (x64 + 4.0 * pio2) : (x64 - 4.0 * pio2));
        }
        return lm_k_sinf(negative ? (-x64 - 3.0 * pio2) : (x64 - 3.0 * pio2));
    }
    if (ix >= 0x7f800000u) {
        return x - x;
    }
    n = lm_rem_pio2f(x, &y);
    switch ((uint32_t)n & 3u) {
    case 0u:
        return lm_k_cosf(y);
    case 1u:
        return lm_k_sinf(-y);
    case 2u:
        return -lm_k_cosf(y);
    default:
        return lm_k_sinf(y);
    }
}

/* FreeBSD msun s_tanf.c. */
static float lm_tanf(float x)
{
    const double pio2 = 0x1.921fb54442d18p+0;
    const double x64 = (double)x;
    const uint32_t ix = lm_bitsf(x) & 0x7fffffffu;
    const int negative = (lm_bitsf(x) >> 31) != 0u;
    double y;
    int32_t n;
    if (ix <= 0x3f490fdau) {
        return (ix < 0x39800000u) ? x : lm_k_tanf(x64, 0);
    }
    if (ix <= 0x407b53d1u) {
        if (ix <= 0x4016cbe3u) {
            return lm_k_tanf(negative ? (x64 + 1.0 * pio2) : (x64 - 1.0 * pio2), 1);
        }
        return lm_k_tanf(negative ? (x64 + 2.0 * pio2) : (x64 - 2.0 * pio2), 0);
    }
    if (ix <= 0x40e231d5u) {
        if (ix <= 0x40afeddfu) {
            return lm_k_tanf(negative ? (x64 + 3.0 * pio2) : (x64 - 3.0 * pio2), 1);
        }
        return lm_k_tanf(negative ? (x64 + 4.0 * pio2) : (x64 - 4.0 * pio2), 0);
    }
    if (ix >= 0x7f800000u) {
        return x - x;
    }
    n = lm_rem_pio2f(x, &y);
    return lm_k_tanf(y, (int)((uint32_t)n & 1u));
}
