/* FreeBSD msun e_log.c: x = 2^k (1 + f), and log(1 + f) by a polynomial in f/(2 + f). */
static double lm_log(double argument)
{
    const double ln2_hi = 0x1.62e42feep-1;
    const double ln2_lo = 0x1.a39ef35793c76p-33;
    const double lg1 = 0x1.5555555555593p-1;
    const double lg2 = 0x1.999999997fa04p-2;
    const double lg3 = 0x1.2492494229359p-2;
    const double lg4 = 0x1.c71c51d8e78afp-3;
    const double lg5 = 0x1.7466496cb03dep-3;
    const double lg6 = 0x1.39a09d078c69fp-3;
    const double lg7 = 0x1.2f112df3e5244p-3;
    double x = argument;
    double f;
    double hfsq;
    double s;
    double z;
    double w;
    double t1;
    double t2;
    double r;
    double dk;
    uint32_t hx = lm_high(x);
    int32_t k = 0;
    if ((hx < 0x00100000u) || ((hx >> 31) != 0u)) {
        if ((lm_bits(x) << 1) == 0u) {
            return -1.0 / (x * x);
        }
        if ((hx >> 31) != 0u) {
            return (x - x) / 0.0;
        }
        k -= 54;
        x *= 0x1p+54;
        hx = lm_high(x);
    } else if (hx >= 0x7ff00000u) {
        return x;
    } else if ((hx == 0x3ff00000u) && (lm_low(x) == 0u)) {
        return 0.0;
    } else {
        /* Normal. */
    }
    hx += 0x3ff00000u - 0x3fe6a09eu;
    k += (int32_t)(hx >> 20) - 0x3ff;
    hx = (hx & 0x000fffffu) + 0x3fe6a09eu;
    x = lm_with_high(x, hx);
    f = x - 1.0;
    hfsq = 0.5 * f * f;
    s = f / (2.0 + f);
    z = s * s;
    w = z * z;
    t1 = w * (lg2 + w * (lg4 + w * lg6));
    t2 = z * (lg1 + w * (lg3 + w * (lg5 + w * lg7)));
    r = t2 + t1;
    dk = (double)k;
    return s * (hfsq + r) + dk * ln2_lo - hfsq + f + dk * ln2_hi;
}

/* FreeBSD msun e_logf.c. */
static float lm_logf(float argument)
{
    const float ln2_hi = 0x1.62e3p-1f;
    const float ln2_lo = 0x1.2fefa2p-17f;
    const float lg1 = 0x1.555554p-1f;
    const float lg2 = 0x1.999c26p-2f;
    const float lg3 = 0x1.23d3dcp-2f;
    const float lg4 = 0x1.f13c4cp-3f;
    float x = argument;
    float f;
    float hfsq;
    float s;
    float z;
    float w;
    float t1;
    float t2;
    float r;
    float dk;
    uint32_t ix = lm_bitsf(x);
    int32_t k = 0;
    if ((ix < 0x00800000u) || ((ix >> 31) != 0u)) {
        if ((ix << 1) == 0u) {
            return -1.0f / (x * x);
        }
        if ((ix >> 31) != 0u) {
            return (x - x) / 0.0f;
        }
        k -= 25;
        x *= 0x1p+25f;
        ix = lm_bitsf(x);
    } else if (ix >= 0x7f800000u) {
        return x;
    } else if (ix == 0x3f800000u) {
        return 0.0f;
    } else {
        /* Normal. */
    }
    ix += 0x3f800000u - 0x3f3504f3u;
    k += (int32_t)(ix >> 23) - 0x7f;
    ix = (ix & 0x007fffffu) + 0x3f3504f3u;
    x = lm_from_bitsf(ix);
    f = x - 1.0f;
    s = f / (2.0f + f);
    z = s * s;
    w = z * z;
    t1 = w * (lg2 + w * lg4);
    t2 = z * (lg1 + w * lg3);
    r = t2 + t1;
    hfsq = 0.5f * f * f;
    dk = (float)k;
    return s * (hfsq + r) + dk * ln2_lo - hfsq + f + dk * ln2_hi;
}

/* FreeBSD msun e_log10.c. */
static double lm_log10(double argument)
{
    const double ivln10hi = 0x1.bcb7b152p-2;
    const double ivln10lo = 0x1.b9438ca9aadd5p-36;
    const double log10_2hi = 0x1.34413509f6p-2;
    const double log10_2lo = 0x1.9fef311f12b36p-42;
    const double lg1 = 0x1.5555555555593p-1;
    const double lg2 = 0x1.999999997fa04p-2;
    const double lg3 = 0x1.2492494229359p-2;
    const double lg4 = 0x1.c71c51d8e78afp-3;
    const double lg5 = 0x1.7466496cb03dep-3;
    const double lg6 = 0x1.39a09d078c69fp-3;
    const double lg7 = 0x1.2f112df3e5244p-3;
    double x = argument;
    double f;
    double hfsq;
    double s;
    double z;
    double w;
    double t1;
    double t2;
    double r;
    double dk;
    double y;
    double hi;
    double lo;
    double val_hi;
    double val_lo;
    uint32_t hx = lm_high(x);
    int32_t k = 0;
    if ((hx < 0x00100000u) || ((hx >> 31) != 0u)) {
        if ((lm_bits(x) << 1) == 0u) {
            return -1.0 / (x * x);
        }
        if ((hx >> 31) != 0u) {
            return (x - x) / 0.0;
        }
        k -= 54;
        x *= 0x1p+54;
        hx = lm_high(x);
    } else if (hx >= 0x7ff00000u) {
        return x;
    } else if ((hx == 0x3ff00000u) && (lm_low(x) == 0u)) {
        return 0.0;
    } else {
        /* Normal. */
    }
    hx += 0x3ff00000u - 0x3fe6a09eu;
    k += (int32_t)(hx >> 20) - 0x3ff;
    hx = (hx & 0x000fffffu) + 0x3fe6a09eu;
    x = lm_with_high(x, hx);
    f = x - 1.0;
    hfsq = 0.5 * f * f;
    s = f / (2.0 + f);
    z = s * s;
    w = z * z;
    t1 = w * (lg2 + w * (lg4 + w * lg6));
    t2 = z * (lg1 + w * (lg3 + w * (lg5 + w * lg7)));
    r = t2 + t1;
    hi = lm_without_low(f - hfsq);
    lo = f - hi - hfsq + s * (hfsq + r);
    val_hi = hi * ivln10hi;
    dk = (double)k;
    y = dk * log10_2hi;
    val_lo = dk * log10_2lo + (lo + hi) * ivln10lo + lo * ivln10hi;
    w = y + val_hi;
    val_lo += (y - w) + val_hi;
    val_hi = w;
    return val_lo + val_hi;
}

/* FreeBSD msun e_log10f.c. */
static float lm_log10f(float argument)
{
    const float ivln10hi = 0x1.bccp-2f;
    const float ivln10lo = -0x1.09d5b2p-15f;
    const float log10_2hi = 0x1.3441p-2f;
    const float log10_2lo = 0x1.a84fb6p-21f;
    const float lg1 = 0x1.555554p-1f;
    const float lg2 = 0x1.999c26p-2f;
    const float lg3 = 0x1.23d3dcp-2f;
    const float lg4 = 0x1.f13c4cp-3f;
    float x = argument;
    float f;
    float hfsq;
    float s;
    float z;
    float w;
    float t1;
    float t2;
    float r;
    float dk;
    float hi;
    float lo;
    uint32_t ix = lm_bitsf(x);
    int32_t k = 0;
    if ((ix < 0x00800000u) || ((ix >> 31) != 0u)) {
        if ((ix << 1) == 0u) {
            return -1.0f / (x * x);
        }
        if ((ix >> 31) != 0u) {
            return (x - x) / 0.0f;
        }
        k -= 25;
        x *= 0x1p+25f;
        ix = lm_bitsf(x);
    } else if (ix >= 0x7f800000u) {
        return x;
    } else if (ix == 0x3f800000u) {
        return 0.0f;
    } else {
        /* Normal. */
    }
    ix += 0x3f800000u - 0x3f3504f3u;
    k += (int32_t)(ix >> 23) - 0x7f;
    ix = (ix & 0x007fffffu) + 0x3f3504f3u;
    x = lm_from_bitsf(ix);
    f = x - 1.0f;
    s = f / (2.0f + f);
    z = s * s;
    w = z * z;
    t1 = w * (lg2 + w * lg4);
    t2 = z * (lg1 + w * lg3);
    r = t2 + t1;
    hfsq = 0.5f * f * f;
    hi = lm_from_bitsf(lm_bitsf(f - hfsq) & 0xfffff000u);
    lo = f - hi - hfsq + s * (hfsq + r);
    dk = (float)k;
    return dk * log10_2lo + (lo + hi) * ivln10lo + lo * ivln10hi + hi * ivln10hi + dk * log10_2hi;
}

/* FreeBSD msun s_log1p.c: log(1 + x). */
static double lm_log1p(double x)
{
    const double ln2_hi = 0x1.62e42feep-1;
    const double ln2_lo = 0x1.a39ef35793c76p-33;
    const double lg1 = 0x1.5555555555593p-1;
    const double lg2 = 0x1.999999997fa04p-2;
    const double lg3 = 0x1.2492494229359p-2;
    const double lg4 = 0x1.c71c51d8e78afp-3;
    const double lg5 = 0x1.7466496cb03dep-3;
    const double lg6 = 0x1.39a09d078c69fp-3;
    const double lg7 = 0x1.2f112df3e5244p-3;
    double f = 0.0;
    double c = 0.0;
    double hfsq;
    double s;
    double z;
    double w;
    double t1;
    double t2;
    double r;
    double dk;
    const uint32_t hx = lm_high(x);
    int32_t k = 1;
    if ((hx < 0x3fda827au) || ((hx >> 31) != 0u)) {
        if (hx >= 0xbff00000u) {
            if (x == -1.0) {
                return x / 0.0;
            }
            return (x - x) / 0.0;
        }
        if ((hx << 1) < (0x3ca00000u << 1)) {
            return x;
        }
        if (hx <= 0xbfd2bec4u) {
            k = 0;
            c = 0.0;
            f = x;
        }
    } else if (hx >= 0x7ff00000u) {
        return x;
    } else {
        /* 1 + x is beyond sqrt(2). */
    }
    if (k > 0) {
        double u = 1.0 + x;
        uint32_t hu = lm_high(u) + (0x3ff00000u - 0x3fe6a09eu);
        k = (int32_t)(hu >> 20) - 0x3ff;
        if (k < 54) {
            c = (k >= 2) ? (1.0 - (u - x)) : (x - (u - 1.0));
            c /= u;
        } else {
            c = 0.0;
        }
        hu = (hu & 0x000fffffu) + 0x3fe6a09eu;
        u = lm_with_high(u, hu);
        f = u - 1.0;
    }
    hfsq = 0.5 * f * f;
    s = f / (2.0 + f);
    z = s * s;
    w = z * z;
    t1 = w * (lg2 + w * (lg4 + w * lg6));
    t2 = z * (lg1 + w * (lg3 + w * (lg5 + w * lg7)));
    r = t2 + t1;
    dk = (double)k;
    return s * (hfsq + r) + (dk * ln2_lo + c) - hfsq + f + dk * ln2_hi;
}

/* FreeBSD msun s_log1pf.c. */
static float lm_log1pf(float x)
{
    const float ln2_hi = 0x1.62e3p-1f;
    const float ln2_lo = 0x1.2fefa2p-17f;
    const float lg1 = 0x1.555554p-1f;
    const float lg2 = 0x1.999c26p-2f;
    const float lg3 = 0x1.23d3dcp-2f;
    const float lg4 = 0x1.f13c4cp-3f;
    float f = 0.0f;
    float c = 0.0f;
    float hfsq;
    float s;
    float z;
    float w;
    float t1;
    float t2;
    float r;
    float dk;
    const uint32_t ix = lm_bitsf(x);
    int32_t k = 1;
    if ((ix < 0x3ed413d0u) || ((ix >> 31) != 0u)) {
        if (ix >= 0xbf800000u) {
            if (x == -1.0f) {
                return x / 0.0f;
            }
            return (x - x) / 0.0f;
        }
        if ((ix << 1) < (0x33800000u << 1)) {
            return x;
        }
        if (ix <= 0xbe95f619u) {
            k = 0;
            c = 0.0f;
            f = x;
        }
    } else if (ix >= 0x7f800000u) {
        return x;
    } else {
        /* 1 + x is beyond sqrt(2). */
    }
    if (k > 0) {
        const float u = 1.0f + x;
        uint32_t iu = lm_bitsf(u) + (0x3f800000u - 0x3f3504f3u);
        k = (int32_t)(iu >> 23) - 0x7f;
        if (k < 25) {
            c = (k >= 2) ? (1.0f - (u - x)) : (x - (u - 1.0f));
            c /= u;
        } else {
            c = 0.0f;
        }
        iu = (iu & 0x007fffffu) + 0x3f3504f3u;
        f = lm_from_bitsf(iu) - 1.0f;
    }
    s = f / (2.0f + f);
    z = s * s;
    w = z * z;
    t1 = w * (lg2 + w * lg4);
    t2 = z * (lg1 + w * lg3);
    r = t2 + t1;
    hfsq = 0.5f * f * f;
    dk = (float)k;
    return s * (hfsq + r) + (dk * ln2_lo + c) - hfsq + f + dk * ln2_hi;
}
