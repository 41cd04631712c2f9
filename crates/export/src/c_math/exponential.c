/* FreeBSD msun e_exp.c. Reduction to |r| <= ln(2)/2, a rational approximation of exp(r), and a power of 2. */
static double lm_exp(double argument)
{
    const double ln2_hi = 0x1.62e42feep-1;
    const double ln2_lo = 0x1.a39ef35793c76p-33;
    const double inv_ln2 = 0x1.71547652b82fep+0;
    const double p1 = 0x1.555555555553ep-3;
    const double p2 = -0x1.6c16c16bebd93p-9;
    const double p3 = 0x1.1566aaf25de2cp-14;
    const double p4 = -0x1.bbd41c5d26bf1p-20;
    const double p5 = 0x1.6376972bea4dp-25;
    double x = argument;
    double hi;
    double lo;
    double c;
    double xx;
    double y;
    int32_t k;
    uint32_t hx = lm_high(x);
    const int32_t sign = (int32_t)(hx >> 31);
    hx &= 0x7fffffffu;
    if (hx >= 0x4086232bu) {
        if (x != x) {
            return x;
        }
        if (x > 0x1.62e42fefa39efp+9) {
            return x * 0x1p+1023;
        }
        if (x < -0x1.74910d52d3051p+9) {
            return 0.0;
        }
    }
    if (hx > 0x3fd62e42u) {
        if (hx >= 0x3ff0a2b2u) {
            k = (int32_t)(inv_ln2 * x + ((sign != 0) ? -0.5 : 0.5));
        } else {
            k = 1 - sign - sign;
        }
        hi = x - (double)k * ln2_hi;
        lo = (double)k * ln2_lo;
        x = hi - lo;
    } else if (hx > 0x3e300000u) {
        k = 0;
        hi = x;
        lo = 0.0;
    } else {
        return 1.0 + x;
    }
    xx = x * x;
    c = x - xx * (p1 + xx * (p2 + xx * (p3 + xx * (p4 + xx * p5))));
    y = 1.0 + (x * c / (2.0 - c) - lo + hi);
    return (k == 0) ? y : lm_scalbn(y, k);
}

/* FreeBSD msun e_expf.c. */
static float lm_expf(float argument)
{
    const float ln2_hi = 0x1.62e4p-1f;
    const float ln2_lo = 0x1.7f7d1cp-20f;
    const float inv_ln2 = 0x1.715476p+0f;
    const float p1 = 0x1.55551ep-3f;
    const float p2 = -0x1.6aa42ap-9f;
    float x = argument;
    float hi;
    float lo;
    float c;
    float xx;
    float y;
    int32_t k;
    uint32_t hx = lm_bitsf(x);
    const int32_t sign = (int32_t)(hx >> 31);
    hx &= 0x7fffffffu;
    if (hx >= 0x42aeac50u) {
        if (hx > 0x7f800000u) {
            return x;
        }
        if ((hx >= 0x42b17218u) && (sign == 0)) {
            return x * 0x1p+127f;
        }
        if ((sign != 0) && (hx >= 0x42cff1b5u)) {
            return 0.0f;
        }
    }
    if (hx > 0x3eb17218u) {
        if (hx > 0x3f851592u) {
            k = (int32_t)(inv_ln2 * x + ((sign != 0) ? -0.5f : 0.5f));
        } else {
            k = 1 - sign - sign;
        }
        hi = x - (float)k * ln2_hi;
        lo = (float)k * ln2_lo;
        x = hi - lo;
    } else if (hx > 0x39000000u) {
        k = 0;
        hi = x;
        lo = 0.0f;
    } else {
        return 1.0f + x;
    }
    xx = x * x;
    c = x - xx * (p1 + xx * p2);
    y = 1.0f + (x * c / (2.0f - c) - lo + hi);
    return (k == 0) ? y : lm_scalbnf(y, k);
}

/* FreeBSD msun s_expm1.c: exp(x) - 1. */
static double lm_expm1(double argument)
{
    const double ln2_hi = 0x1.62e42feep-1;
    const double ln2_lo = 0x1.a39ef35793c76p-33;
    const double inv_ln2 = 0x1.71547652b82fep+0;
    const double q1 = -0x1.11111111110f4p-5;
    const double q2 = 0x1.a01a019fe5585p-10;
    const double q3 = -0x1.4ce199eaadbb7p-14;
    const double q4 = 0x1.0cfca86e65239p-18;
    const double q5 = -0x1.afdb76e09c32dp-23;
    double x = argument;
    double hi;
    double lo;
    double c;
    double t;
    double y;
    double hfx;
    double hxs;
    double r1;
    double e;
    double twopk;
    double uf;
    int32_t k;
    const uint32_t hx = lm_high(x) & 0x7fffffffu;
    const int negative = (lm_high(x) >> 31) != 0u;
    if (hx >= 0x4043687au) {
        if (x != x) {
            return x;
        }
        if (negative) {
            return -1.0;
        }
        if (x > 0x1.62e42fefa39efp+9) {
            return x * 0x1p+1023;
        }
    }
    if (hx > 0x3fd62e42u) {
        if (hx < 0x3ff0a2b2u) {
            if (!negative) {
                hi = x - ln2_hi;
                lo = ln2_lo;
                k = 1;
            } else {
                hi = x + ln2_hi;
                lo = -ln2_lo;
                k = -1;
            }
        } else {
            k = (int32_t)(inv_ln2 * x + (negative ? -0.5 : 0.5));
            t = (double)k;
            hi = x - t * ln2_hi;
            lo = t * ln2_lo;
        }
        x = hi - lo;
        c = (hi - x) - lo;
    } else if (hx < 0x3c900000u) {
        return x;
    } else {
        c = 0.0;
        k = 0;
    }
    hfx = 0.5 * x;
    hxs = x * hfx;
    r1 = 1.0 + hxs * (q1 + hxs * (q2 + hxs * (q3 + hxs * (q4 + hxs * q5))));
    t = 3.0 - r1 * hfx;
    e = hxs * ((r1 - t) / (6.0 - x * t));
    if (k == 0) {
        return x - (x * e - hxs);
    }
    e = x * (e - c) - c;
    e -= hxs;
    if (k == -1) {
        return 0.5 * (x - e) - 0.5;
    }
    if (k == 1) {
        if (x < -0.25) {
            return -2.0 * (e - (x + 0.5));
        }
        return 1.0 + 2.0 * (x - e);
    }
    twopk = lm_from_bits((uint64_t)(uint32_t)(0x3ff + k) << 52);
    if ((k < 0) || (k > 56)) {
        y = x - e + 1.0;
        if (k == 1024) {
            y = y * 2.0 * 0x1p+1023;
        } else {
            y = y * twopk;
        }
        return y - 1.0;
    }
    uf = lm_from_bits((uint64_t)(uint32_t)(0x3ff - k) << 52);
    if (k < 20) {
        y = (x - e + (1.0 - uf)) * twopk;
    } else {
        y = (x - (e + uf) + 1.0) * twopk;
    }
    return y;
}

/* FreeBSD msun s_expm1f.c. */
static float lm_expm1f(float argument)
{
    const float ln2_hi = 0x1.62e3p-1f;
    const float ln2_lo = 0x1.2fefa2p-17f;
    const float inv_ln2 = 0x1.715476p+0f;
    const float q1 = -0x1.1110dp-5f;
    const float q2 = 0x1.9e602p-10f;
    float x = argument;
    float hi;
    float lo;
    float c;
    float t;
    float y;
    float hfx;
    float hxs;
    float r1;
    float e;
    float twopk;
    float uf;
    int32_t k;
    const uint32_t hx = lm_bitsf(x) & 0x7fffffffu;
    const int negative = (lm_bitsf(x) >> 31) != 0u;
    if (hx >= 0x4195b844u) {
        if (hx > 0x7f800000u) {
            return x;
        }
        if (negative) {
            return -1.0f;
        }
        if (hx > 0x42b17217u) {
            return x * 0x1p+127f;
        }
    }
    if (hx > 0x3eb17218u) {
        if (hx < 0x3f851592u) {
            if (!negative) {
                hi = x - ln2_hi;
                lo = ln2_lo;
                k = 1;
            } else {
                hi = x + ln2_hi;
                lo = -ln2_lo;
                k = -1;
            }
        } else {
            k = (int32_t)(inv_ln2 * x + (negative ? -0.5f : 0.5f));
            t = (float)k;
            hi = x - t * ln2_hi;
            lo = t * ln2_lo;
        }
        x = hi - lo;
        c = (hi - x) - lo;
    } else if (hx < 0x33000000u) {
        return x;
    } else {
        c = 0.0f;
        k = 0;
    }
    hfx = 0.5f * x;
    hxs = x * hfx;
    r1 = 1.0f + hxs * (q1 + hxs * q2);
    t = 3.0f - r1 * hfx;
    e = hxs * ((r1 - t) / (6.0f - x * t));
    if (k == 0) {
        return x - (x * e - hxs);
    }
    e = x * (e - c) - c;
    e -= hxs;
    if (k == -1) {
        return 0.5f * (x - e) - 0.5f;
    }
    if (k == 1) {
        if (x < -0.25f) {
            return -2.0f * (e - (x + 0.5f));
        }
        return 1.0f + 2.0f * (x - e);
    }
    twopk = lm_from_bitsf((uint32_t)(0x7f + k) << 23);
    if ((k < 0) || (k > 56)) {
        y = x - e + 1.0f;
        if (k == 128) {
            y = y * 2.0f * 0x1p+127f;
        } else {
            y = y * twopk;
        }
        return y - 1.0f;
    }
    uf = lm_from_bitsf((uint32_t)(0x7f - k) << 23);
    if (k < 23) {
        y = (x - e + (1.0f - uf)) * twopk;
    } else {
        y = (x - (e + uf) + 1.0f) * twopk;
    }
    return y;
}

/* musl __expo2.c: exp(x)/2 beyond the range of exp. */
static double lm_expo2(double x)
{
    const double scale = 0x1p+1021;
    return lm_exp(x - 0x1.62066151add8bp+10) * scale * scale;
}

/* musl __expo2f.c. */
static float lm_expo2f(float x)
{
    const float scale = 0x1p+117f;
    return lm_expf(x - 0x1.45c778p+7f) * scale * scale;
}
