/* FreeBSD msun e_asin.c: the rational part of asin. */
static double lm_asin_r(double z)
{
    const double ps0 = 0x1.5555555555555p-3;
    const double ps1 = -0x1.4d61203eb6f7dp-2;
    const double ps2 = 0x1.9c1550e884455p-3;
    const double ps3 = -0x1.48228b5688f3bp-5;
    const double ps4 = 0x1.9efe07501b288p-11;
    const double ps5 = 0x1.23de10dfdf709p-15;
    const double qs1 = -0x1.33a271c8a2d4bp+1;
    const double qs2 = 0x1.02ae59c598ac8p+1;
    const double qs3 = -0x1.6066c1b8d0159p-1;
    const double qs4 = 0x1.3b8c5b12e9282p-4;
    const double p = z * (ps0 + z * (ps1 + z * (ps2 + z * (ps3 + z * (ps4 + z * ps5)))));
    const double q = 1.0 + z * (qs1 + z * (qs2 + z * (qs3 + z * qs4)));
    return p / q;
}

/* FreeBSD msun e_asinf.c. */
static float lm_asin_rf(float z)
{
    const float ps0 = 0x1.5554eap-3f;
    const float ps1 = -0x1.5e2774p-5f;
    const float ps2 = -0x1.1ba6d6p-7f;
    const float qs1 = -0x1.69cb5cp-1f;
    const float p = z * (ps0 + z * (ps1 + z * ps2));
    const float q = 1.0f + z * qs1;
    return p / q;
}

/* FreeBSD msun e_asin.c. */
static double lm_asin(double argument)
{
    const double pio2_hi = 0x1.921fb54442d18p+0;
    const double pio2_lo = 0x1.1a62633145c07p-54;
    double x = argument;
    double z;
    double r;
    double s;
    const uint32_t hx = lm_high(x);
    const uint32_t ix = hx & 0x7fffffffu;
    if (ix >= 0x3ff00000u) {
        if (((ix - 0x3ff00000u) | lm_low(x)) == 0u) {
            return x * pio2_hi + 0x1p-120;
        }
        return 0.0 / (x - x);
    }
    if (ix < 0x3fe00000u) {
        if ((ix >= 0x00100000u) && (ix < 0x3e500000u)) {
            return x;
        }
        return x + x * lm_asin_r(x * x);
    }
    z = (1.0 - fabs(x)) * 0.5;
    s = sqrt(z);
    r = lm_asin_r(z);
    if (ix >= 0x3fef3333u) {
        x = pio2_hi - (2.0 * (s + s * r) - pio2_lo);
    } else {
        const double f = lm_without_low(s);
        const double c = (z - f * f) / (s + f);
        x = 0.5 * pio2_hi - (2.0 * s * r - (pio2_lo - 2.0 * c) - (0.5 * pio2_hi - 2.0 * f));
    }
    return ((hx >> 31) != 0u) ? -x : x;
}

/* In binary32 arithmetic alone, with the branches of FreeBSD msun e_asin.c. */
static float lm_asinf(float argument)
{
    const float pio2_hi = 0x1.921fb6p+0f;
    const float pio2_lo = -0x1.777a5cp-25f;
    const float x = fabsf(argument);
    float z;
    float s;
    float f;
    float c;
    float r;
    if (!(x < 1.0f)) {
        return (x == 1.0f) ? (argument * pio2_hi) : (0.0f / (x - x));
    }
    if (x < 0.5f) {
        return argument + argument * lm_asin_rf(x * x);
    }
    z = (1.0f - x) * 0.5f;
    s = sqrtf(z);
    f = lm_from_bitsf(lm_bitsf(s) & 0xfffff000u);
    c = (z - f * f) / (s + f);
    r = 2.0f * s * lm_asin_rf(z) - (pio2_lo - 2.0f * c);
    r = 0.5f * pio2_hi - (r - (0.5f * pio2_hi - 2.0f * f));
    return (argument < 0.0f) ? -r : r;
}

/* FreeBSD msun e_acos.c. */
static double lm_acos(double x)
{
    const double pio2_hi = 0x1.921fb54442d18p+0;
    const double pio2_lo = 0x1.1a62633145c07p-54;
    double z;
    double w;
    double s;
    double c;
    double df;
    const uint32_t hx = lm_high(x);
    const uint32_t ix = hx & 0x7fffffffu;
    if (ix >= 0x3ff00000u) {
        if (((ix - 0x3ff00000u) | lm_low(x)) == 0u) {
            if ((hx >> 31) != 0u) {
                return 2.0 * pio2_hi + 0x1p-120;
            }
            return 0.0;
        }
        return 0.0 / (x - x);
    }
    if (ix < 0x3fe00000u) {
        if (ix <= 0x3c600000u) {
            return pio2_hi + 0x1p-120;
        }
        return pio2_hi - (x - (pio2_lo - x * lm_asin_r(x * x)));
    }
    if ((hx >> 31) != 0u) {
        z = (1.0 + x) * 0.5;
        s = sqrt(z);
        w = lm_asin_r(z) * s - pio2_lo;
        return 2.0 * (pio2_hi - (s + w));
    }
    z = (1.0 - x) * 0.5;
    s = sqrt(z);
    df = lm_without_low(s);
    c = (z - df * df) / (s + df);
    w = lm_asin_r(z) * s + c;
    return 2.0 * (df + w);
}

/* FreeBSD msun e_acosf.c. */
static float lm_acosf(float x)
{
    const float pio2_hi = 0x1.921fb4p+0f;
    const float pio2_lo = 0x1.4442dp-24f;
    float z;
    float w;
    float s;
    float c;
    float df;
    const uint32_t hx = lm_bitsf(x);
    const uint32_t ix = hx & 0x7fffffffu;
    if (ix >= 0x3f800000u) {
        if (ix == 0x3f800000u) {
            if ((hx >> 31) != 0u) {
                return 2.0f * pio2_hi + 0x1p-120f;
            }
            return 0.0f;
        }
        return 0.0f / (x - x);
    }
    if (ix < 0x3f000000u) {
        if (ix <= 0x32800000u) {
            return pio2_hi + 0x1p-120f;
        }
        return pio2_hi - (x - (pio2_lo - x * lm_asin_rf(x * x)));
    }
    if ((hx >> 31) != 0u) {
        z = (1.0f + x) * 0.5f;
        s = sqrtf(z);
        w = lm_asin_rf(z) * s - pio2_lo;
        return 2.0f * (pio2_hi - (s + w));
    }
    z = (1.0f - x) * 0.5f;
    s = sqrtf(z);
    df = lm_from_bitsf(lm_bitsf(s) & 0xfffff000u);
    c = (z - df * df) / (s + df);
    w = lm_asin_rf(z) * s + c;
    return 2.0f * (df + w);
}

/* FreeBSD msun s_atan.c. */
static double lm_atan(double argument)
{
    static const double hi[4] = {
        0x1.dac670561bb4fp-2, 0x1.921fb54442d18p-1, 0x1.f730bd281f69bp-1, 0x1.921fb54442d18p+0,
    };
    static const double lo[4] = {
        0x1.a2b7f222f65e2p-56, 0x1.1a62633145c07p-55, 0x1.007887af0cbbdp-56, 0x1.1a62633145c07p-54,
    };
    static const double at[11] = {
        0x1.555555555550dp-2, -0x1.999999998ebc4p-3, 0x1.24924920083ffp-3,
        -0x1.c71c6fe231671p-4, 0x1.745cdc54c206ep-4, -0x1.3b0f2af749a6dp-4,
        0x1.10d66a0d03d51p-4, -0x1.dde2d52defd9ap-5, 0x1.97b4b24760debp-5,
        -0x1.2b4442c6a6c2fp-5, 0x1.0ad3ae322da11p-6,
    };
    double x = argument;
    double z;
    double w;
    double s1;
    double s2;
    int32_t id = -1;
    const uint32_t ix = lm_high(x) & 0x7fffffffu;
    const int negative = (lm_high(x) >> 31) != 0u;
    if (ix >= 0x44100000u) {
        if (x != x) {
            return x;
        }
        return negative ? -hi[3] : hi[3];
    }
    if (ix < 0x3fdc0000u) {
        if (ix < 0x3e400000u) {
            return x;
        }
    } else {
        x = fabs(x);
        if (ix < 0x3ff30000u) {
            if (ix < 0x3fe60000u) {
                x = (2.0 * x - 1.0) / (2.0 + x);
                id = 0;
            } else {
                x = (x - 1.0) / (x + 1.0);
                id = 1;
            }
        } else if (ix < 0x40038000u) {
            x = (x - 1.5) / (1.0 + 1.5 * x);
            id = 2;
        } else {
            x = -1.0 / x;
            id = 3;
        }
    }
    z = x * x;
    w = z * z;
    s1 = z * (at[0] + w * (at[2] + w * (at[4] + w * (at[6] + w * (at[8] + w * at[10])))));
    s2 = w * (at[1] + w * (at[3] + w * (at[5] + w * (at[7] + w * at[9]))));
    if (id < 0) {
        return x - x * (s1 + s2);
    }
    z = hi[id] - (x * (s1 + s2) - lo[id] - x);
    return negative ? -z : z;
}

/* FreeBSD msun s_atanf.c. */
static float lm_atanf(float argument)
{
    static const float hi[4] = {
        0x1.dac67p-2f, 0x1.921fb4p-1f, 0x1.f730bcp-1f, 0x1.921fb4p+0f,
    };
    static const float lo[4] = {
        0x1.586ed2p-28f, 0x1.4442dp-25f, 0x1.281f68p-25f, 0x1.4442dp-24f,
    };
    static const float at[5] = {
        0x1.555552p-2f, -0x1.99953p-3f, 0x1.23ea1ap-3f, -0x1.b4248ep-4f, 0x1.f9584ap-5f,
    };
    float x = argument;
    float z;
    float w;
    float s1;
    float s2;
    int32_t id = -1;
    const uint32_t ix = lm_bitsf(x) & 0x7fffffffu;
    const int negative = (lm_bitsf(x) >> 31) != 0u;
    if (ix >= 0x4c800000u) {
        if (x != x) {
            return x;
        }
        z = hi[3] + 0x1p-120f;
        return negative ? -z : z;
    }
    if (ix < 0x3ee00000u) {
        if (ix < 0x39800000u) {
            return x;
        }
    } else {
        x = fabsf(x);
        if (ix < 0x3f980000u) {
            if (ix < 0x3f300000u) {
                x = (2.0f * x - 1.0f) / (2.0f + x);
                id = 0;
            } else {
                x = (x - 1.0f) / (x + 1.0f);
                id = 1;
            }
        } else if (ix < 0x401c0000u) {
            x = (x - 1.5f) / (1.0f + 1.5f * x);
            id = 2;
        } else {
            x = -1.0f / x;
            id = 3;
        }
    }
    z = x * x;
    w = z * z;
    s1 = z * (at[0] + w * (at[2] + w * at[4]));
    s2 = w * (at[1] + w * at[3]);
    if (id < 0) {
        return x - x * (s1 + s2);
    }
    z = hi[id] - ((x * (s1 + s2) - lo[id]) - x);
    return negative ? -z : z;
}

/* FreeBSD msun e_atan2.c. */
static double lm_atan2(double y, double x)
{
    const double pi = 0x1.921fb54442d18p+1;
    const double pi_lo = 0x1.1a62633145c07p-53;
    uint32_t ix = lm_high(x);
    uint32_t iy = lm_high(y);
    const uint32_t lx = lm_low(x);
    const uint32_t ly = lm_low(y);
    uint32_t m;
    double z;
    if ((x != x) || (y != y)) {
        return x + y;
    }
    if (((ix - 0x3ff00000u) | lx) == 0u) {
        return lm_atan(y);
    }
    m = ((iy >> 31) & 1u) | ((ix >> 30) & 2u);
    ix &= 0x7fffffffu;
    iy &= 0x7fffffffu;
    if ((iy | ly) == 0u) {
        if (m < 2u) {
            return y;
        }
        return (m == 2u) ? pi : -pi;
    }
    if ((ix | lx) == 0u) {
        return ((m & 1u) != 0u) ? (-pi / 2.0) : (pi / 2.0);
    }
    if (ix == 0x7ff00000u) {
        if (iy == 0x7ff00000u) {
            z = ((m & 2u) != 0u) ? (3.0 * pi / 4.0) : (pi / 4.0);
        } else {
            z = ((m & 2u) != 0u) ? pi : 0.0;
        }
        return ((m & 1u) != 0u) ? -z : z;
    }
    if (((ix + (64u << 20)) < iy) || (iy == 0x7ff00000u)) {
        return ((m & 1u) != 0u) ? (-pi / 2.0) : (pi / 2.0);
    }
    if (((m & 2u) != 0u) && ((iy + (64u << 20)) < ix)) {
        z = 0.0;
    } else {
        z = lm_atan(fabs(y / x));
    }
    switch (m) {
    case 0u:
        return z;
    case 1u:
        return -z;
    case 2u:
        return pi - (z - pi_lo);
    default:
        return (z - pi_lo) - pi;
    }
}

/* FreeBSD msun e_atan2f.c. */
static float lm_atan2f(float y, float x)
{
    const float pi = 0x1.921fb6p+1f;
    const float pi_lo = -0x1.777a5cp-24f;
    uint32_t ix = lm_bitsf(x);
    uint32_t iy = lm_bitsf(y);
    uint32_t m;
    float z;
    if ((x != x) || (y != y)) {
        return x + y;
    }
    if (ix == 0x3f800000u) {
        return lm_atanf(y);
    }
    m = ((iy >> 31) & 1u) | ((ix >> 30) & 2u);
    ix &= 0x7fffffffu;
    iy &= 0x7fffffffu;
    if (iy == 0u) {
        if (m < 2u) {
            return y;
        }
        return (m == 2u) ? pi : -pi;
    }
    if (ix == 0u) {
        return ((m & 1u) != 0u) ? (-pi / 2.0f) : (pi / 2.0f);
    }
    if (ix == 0x7f800000u) {
        if (iy == 0x7f800000u) {
            z = ((m & 2u) != 0u) ? (3.0f * pi / 4.0f) : (pi / 4.0f);
        } else {
            z = ((m & 2u) != 0u) ? pi : 0.0f;
        }
        return ((m & 1u) != 0u) ? -z : z;
    }
    if (((ix + (26u << 23)) < iy) || (iy == 0x7f800000u)) {
        return ((m & 1u) != 0u) ? (-pi / 2.0f) : (pi / 2.0f);
    }
    if (((m & 2u) != 0u) && ((iy + (26u << 23)) < ix)) {
        z = 0.0f;
    } else {
        z = lm_atanf(fabsf(y / x));
    }
    switch (m) {
    case 0u:
        return z;
    case 1u:
        return -z;
    case 2u:
        return pi - (z - pi_lo);
    default:
        return (z - pi_lo) - pi;
    }
}
