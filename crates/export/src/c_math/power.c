/* FreeBSD msun e_pow.c: 2^(y log2|x|) with log2|x| in two pieces. */
static double lm_pow(double x, double y)
{
    static const double bp[2] = {1.0, 1.5};
    static const double dp_h[2] = {0.0, 0x1.2b8034p-1};
    static const double dp_l[2] = {0.0, 0x1.cfdeb43cfd006p-27};
    const double huge_value = 0x1.7e43c8800759cp+996;
    const double tiny = 0x1.56e1fc2f8f359p-997;
    const double l1 = 0x1.3333333333303p-1;
    const double l2 = 0x1.b6db6db6fabffp-2;
    const double l3 = 0x1.55555518f264dp-2;
    const double l4 = 0x1.17460a91d4101p-2;
    const double l5 = 0x1.d864a93c9db65p-3;
    const double l6 = 0x1.a7e284a454eefp-3;
    const double p1 = 0x1.555555555553ep-3;
    const double p2 = -0x1.6c16c16bebd93p-9;
    const double p3 = 0x1.1566aaf25de2cp-14;
    const double p4 = -0x1.bbd41c5d26bf1p-20;
    const double p5 = 0x1.6376972bea4dp-25;
    const double lg2 = 0x1.62e42fefa39efp-1;
    const double lg2_h = 0x1.62e43p-1;
    const double lg2_l = -0x1.05c610ca86c39p-29;
    const double ovt = 0x1.71547652b82fep-54;
    const double cp = 0x1.ec709dc3a03fdp-1;
    const double cp_h = 0x1.ec709ep-1;
    const double cp_l = -0x1.e2fe0145b01f5p-28;
    const double ivln2 = 0x1.71547652b82fep+0;
    const double ivln2_h = 0x1.715476p+0;
    const double ivln2_l = 0x1.4ae0bf85ddf44p-26;
    const int x_negative = (lm_high(x) >> 31) != 0u;
    const int y_negative = (lm_high(y) >> 31) != 0u;
    const uint32_t lx = lm_low(x);
    const uint32_t ly = lm_low(y);
    int32_t ix = (int32_t)(lm_high(x) & 0x7fffffffu);
    const int32_t iy = (int32_t)(lm_high(y) & 0x7fffffffu);
    int32_t yisint = 0;
    int32_t i;
    int32_t j;
    int32_t k;
    int32_t n;
    uint32_t jz;
    double ax;
    double s = 1.0;
    double t;
    double t1;
    double t2;
    double u;
    double v;
    double w;
    double r;
    double z;
    double y1;
    double p_h;
    double p_l;
    if (((uint32_t)iy | ly) == 0u) {
        return 1.0;
    }
    if ((!x_negative) && (ix == 0x3ff00000) && (lx == 0u)) {
        return 1.0;
    }
    if ((x != x) || (y != y)) {
        return x + y;
    }
    if (x_negative) {
        if (iy >= 0x43400000) {
            yisint = 2;
        } else if (iy >= 0x3ff00000) {
            k = (iy >> 20) - 0x3ff;
            if (k > 20) {
                const uint32_t whole = ly >> (52 - k);
                if ((whole << (52 - k)) == ly) {
                    yisint = 2 - (int32_t)(whole & 1u);
                }
            } else if (ly == 0u) {
                j = iy >> (20 - k);
                if ((j << (20 - k)) == iy) {
                    yisint = 2 - (j & 1);
                }
            } else {
                /* Not an integer. */
            }
        } else {
            /* Below 1. */
        }
    }
    if (ly == 0u) {
        if (iy == 0x7ff00000) {
            if ((ix == 0x3ff00000) && (lx == 0u)) {
                return 1.0;
            }
            if (ix >= 0x3ff00000) {
                return y_negative ? 0.0 : y;
            }
            return y_negative ? -y : 0.0;
        }
        if (iy == 0x3ff00000) {
            return y_negative ? (1.0 / x) : x;
        }
        if ((!y_negative) && (iy == 0x40000000)) {
            return x * x;
        }
        if ((!y_negative) && (iy == 0x3fe00000) && (!x_negative)) {
            return sqrt(x);
        }
    }
    ax = fabs(x);
    if ((lx == 0u) && ((ix == 0x7ff00000) || (ix == 0) || (ix == 0x3ff00000))) {
        z = y_negative ? (1.0 / ax) : ax;
        if (x_negative) {
            if ((ix == 0x3ff00000) && (yisint == 0)) {
                z = (z - z) / (z - z);
            } else if (yisint == 1) {
                z = -z;
            } else {
                /* The sign is that of an even power. */
            }
        }
        return z;
    }
    if (x_negative) {
        if (yisint == 0) {
            return (x - x) / (x - x);
        }
        if (yisint == 1) {
            s = -1.0;
        }
    }
    if (iy > 0x41e00000) {
        if (iy > 0x43f00000) {
            if (ix <= 0x3fefffff) {
                return y_negative ? (huge_value * huge_value) : (tiny * tiny);
            }
            if (ix >= 0x3ff00000) {
                return y_negative ? (tiny * tiny) : (huge_value * huge_value);
            }
        }
        if (ix < 0x3fefffff) {
            return y_negative ? (s * huge_value * huge_value) : (s * tiny * tiny);
        }
        if (ix > 0x3ff00000) {
            return y_negative ? (s * tiny * tiny) : (s * huge_value * huge_value);
        }
        t = ax - 1.0;
        w = (t * t) * (0.5 - t * (0x1.5555555555555p-2 - t * 0.25));
        u = ivln2_h * t;
        v = t * ivln2_l - w * ivln2;
        t1 = lm_without_low(u + v);
        t2 = v - (t1 - u);
    } else {
        double ss;
        double s2;
        double s_h;
        double s_l;
        double t_h;
        double t_l;
        double z_h;
        double z_l;
        n = 0;
        if (ix < 0x00100000) {
            ax *= 0x1p+53;
            n -= 53;
            ix = (int32_t)lm_high(ax);
        }
        n += (ix >> 20) - 0x3ff;
        j = ix & 0x000fffff;
        ix = j | 0x3ff00000;
        if (j <= 0x3988e) {
            k = 0;
        } else if (j < 0xbb67a) {
            k = 1;
        } else {
            k = 0;
            n += 1;
            ix -= 0x00100000;
        }
        ax = lm_with_high(ax, (uint32_t)ix);
        u = ax - bp[k];
        v = 1.0 / (ax + bp[k]);
        ss = u * v;
        s_h = lm_without_low(ss);
        t_h = lm_with_high(0.0, (((uint32_t)ix >> 1) | 0x20000000u) + 0x00080000u + ((uint32_t)k << 18));
        t_l = ax - (t_h - bp[k]);
        s_l = v * ((u - s_h * t_h) - s_h * t_l);
        s2 = ss * ss;
        r = s2 * s2 * (l1 + s2 * (l2 + s2 * (l3 + s2 * (l4 + s2 * (l5 + s2 * l6)))));
        r += s_l * (s_h + ss);
        s2 = s_h * s_h;
        t_h = lm_without_low(3.0 + s2 + r);
        t_l = r - ((t_h - 3.0) - s2);
        u = s_h * t_h;
        v = s_l * t_h + t_l * ss;
        p_h = lm_without_low(u + v);
        p_l = v - (p_h - u);
        z_h = cp_h * p_h;
        z_l = cp_l * p_h + p_l * cp + dp_l[k];
        t = (double)n;
        t1 = lm_without_low(((z_h + z_l) + dp_h[k]) + t);
        t2 = z_l - (((t1 - t) - dp_h[k]) - z_h);
    }
    y1 = lm_without_low(y);
    p_l = (y - y1) * t1 + y * t2;
    p_h = y1 * t1;
    z = p_l + p_h;
    jz = lm_high(z);
    if ((jz >= 0x40900000u) && (jz < 0x80000000u)) {
        if ((jz != 0x40900000u) || (lm_low(z) != 0u)) {
            return s * huge_value * huge_value;
        }
        if ((p_l + ovt) > (z - p_h)) {
            return s * huge_value * huge_value;
        }
    } else if ((jz & 0x7fffffffu) >= 0x4090cc00u) {
        if ((jz != 0xc090cc00u) || (lm_low(z) != 0u)) {
            return s * tiny * tiny;
        }
        if (p_l <= (z - p_h)) {
            return s * tiny * tiny;
        }
    } else {
        /* In range. */
    }
    i = (int32_t)(jz & 0x7fffffffu);
    k = (i >> 20) - 0x3ff;
    n = 0;
    if (i > 0x3fe00000) {
        uint32_t m = jz + (0x00100000u >> (k + 1));
        k = (int32_t)((m & 0x7fffffffu) >> 20) - 0x3ff;
        t = lm_with_high(0.0, m & ~(0x000fffffu >> k));
        m = ((m & 0x000fffffu) | 0x00100000u) >> (20 - k);
        n = (jz >= 0x80000000u) ? -(int32_t)m : (int32_t)m;
        p_h -= t;
    }
    t = lm_without_low(p_l + p_h);
    u = t * lg2_h;
    v = (p_l - (t - p_h)) * lg2 + t * lg2_l;
    z = u + v;
    w = v - (z - u);
    t = z * z;
    t1 = z - t * (p1 + t * (p2 + t * (p3 + t * (p4 + t * p5))));
    r = (z * t1) / (t1 - 2.0) - (w + z * w);
    z = 1.0 - (r - z);
    j = (int32_t)lm_high(z) + n * 0x00100000;
    if (j < 0x00100000) {
        z = lm_scalbn(z, n);
    } else {
        z = lm_with_high(z, (uint32_t)j);
    }
    return s * z;
}

/* FreeBSD msun e_powf.c. */
static float lm_powf(float x, float y)
{
    static const float bp[2] = {1.0f, 1.5f};
    static const float dp_h[2] = {0.0f, 0x1.2b8p-1f};
    static const float dp_l[2] = {0.0f, 0x1.a39fb8p-20f};
    const float huge_value = 0x1.93e594p+99f;
    const float tiny = 0x1.4484cp-100f;
    const float l1 = 0x1.333334p-1f;
    const float l2 = 0x1.b6db6ep-2f;
    const float l3 = 0x1.555556p-2f;
    const float l4 = 0x1.17460ap-2f;
    const float l5 = 0x1.d864aap-3f;
    const float l6 = 0x1.a7e284p-3f;
    const float p1 = 0x1.555556p-3f;
    const float p2 = -0x1.6c16c2p-9f;
    const float p3 = 0x1.1566aap-14f;
    const float p4 = -0x1.bbd41cp-20f;
    const float p5 = 0x1.637698p-25f;
    const float lg2 = 0x1.62e43p-1f;
    const float lg2_h = 0x1.62e4p-1f;
    const float lg2_l = 0x1.7f7d18p-20f;
    const float ovt = 0x1.715478p-25f;
    const float cp = 0x1.ec709ep-1f;
    const float cp_h = 0x1.ec8p-1f;
    const float cp_l = -0x1.ec478cp-14f;
    const float ivln2 = 0x1.715476p+0f;
    const float ivln2_h = 0x1.7154p+0f;
    const float ivln2_l = 0x1.d94aep-18f;
    const int x_negative = (lm_bitsf(x) >> 31) != 0u;
    const int y_negative = (lm_bitsf(y) >> 31) != 0u;
    int32_t ix = (int32_t)(lm_bitsf(x) & 0x7fffffffu);
    const int32_t iy = (int32_t)(lm_bitsf(y) & 0x7fffffffu);
    int32_t yisint = 0;
    int32_t i;
    int32_t j;
    int32_t k;
    int32_t n;
    uint32_t jz;
    float ax;
    float sn = 1.0f;
    float t;
    float t1;
    float t2;
    float u;
    float v;
    float w;
    float r;
    float z;
    float y1;
    float p_h;
    float p_l;
    if (iy == 0) {
        return 1.0f;
    }
    if ((!x_negative) && (ix == 0x3f800000)) {
        return 1.0f;
    }
    if ((x != x) || (y != y)) {
        return x + y;
    }
    if (x_negative) {
        if (iy >= 0x4b800000) {
            yisint = 2;
        } else if (iy >= 0x3f800000) {
            k = (iy >> 23) - 0x7f;
            j = iy >> (23 - k);
            if ((j << (23 - k)) == iy) {
                yisint = 2 - (j & 1);
            }
        } else {
            /* Below 1. */
        }
    }
    if (iy == 0x7f800000) {
        if (ix == 0x3f800000) {
            return 1.0f;
        }
        if (ix > 0x3f800000) {
            return y_negative ? 0.0f : y;
        }
        return y_negative ? -y : 0.0f;
    }
    if (iy == 0x3f800000) {
        return y_negative ? (1.0f / x) : x;
    }
    if ((!y_negative) && (iy == 0x40000000)) {
        return x * x;
    }
    if ((!y_negative) && (iy == 0x3f000000) && (!x_negative)) {
        return sqrtf(x);
    }
    ax = fabsf(x);
    if ((ix == 0x7f800000) || (ix == 0) || (ix == 0x3f800000)) {
        z = y_negative ? (1.0f / ax) : ax;
        if (x_negative) {
            if ((ix == 0x3f800000) && (yisint == 0)) {
                z = (z - z) / (z - z);
            } else if (yisint == 1) {
                z = -z;
            } else {
                /* The sign is that of an even power. */
            }
        }
        return z;
    }
    if (x_negative) {
        if (yisint == 0) {
            return (x - x) / (x - x);
        }
        if (yisint == 1) {
            sn = -1.0f;
        }
    }
    if (iy > 0x4d000000) {
        if (ix < 0x3f7ffff8) {
            return y_negative ? (sn * huge_value * huge_value) : (sn * tiny * tiny);
        }
        if (ix > 0x3f800007) {
            return y_negative ? (sn * tiny * tiny) : (sn * huge_value * huge_value);
        }
        t = ax - 1.0f;
        w = (t * t) * (0.5f - t * (0x1.555556p-2f - t * 0.25f));
        u = ivln2_h * t;
        v = t * ivln2_l - w * ivln2;
        t1 = lm_from_bitsf(lm_bitsf(u + v) & 0xfffff000u);
        t2 = v - (t1 - u);
    } else {
        float s;
        float s2;
        float s_h;
        float s_l;
        float t_h;
        float t_l;
        float z_h;
        float z_l;
        n = 0;
        if (ix < 0x00800000) {
            ax *= 0x1p+24f;
            n -= 24;
            ix = (int32_t)lm_bitsf(ax);
        }
        n += (ix >> 23) - 0x7f;
        j = ix & 0x007fffff;
        ix = j | 0x3f800000;
        if (j <= 0x1cc471) {
            k = 0;
        } else if (j < 0x5db3d7) {
            k = 1;
        } else {
            k = 0;
            n += 1;
            ix -= 0x00800000;
        }
        ax = lm_from_bitsf((uint32_t)ix);
        u = ax - bp[k];
        v = 1.0f / (ax + bp[k]);
        s = u * v;
        s_h = lm_from_bitsf(lm_bitsf(s) & 0xfffff000u);
        t_h = lm_from_bitsf(((((uint32_t)ix >> 1) & 0xfffff000u) | 0x20000000u) + 0x00400000u + ((uint32_t)k << 21));
        t_l = ax - (t_h - bp[k]);
        s_l = v * ((u - s_h * t_h) - s_h * t_l);
        s2 = s * s;
        r = s2 * s2 * (l1 + s2 * (l2 + s2 * (l3 + s2 * (l4 + s2 * (l5 + s2 * l6)))));
        r += s_l * (s_h + s);
        s2 = s_h * s_h;
        t_h = lm_from_bitsf(lm_bitsf(3.0f + s2 + r) & 0xfffff000u);
        t_l = r - ((t_h - 3.0f) - s2);
        u = s_h * t_h;
        v = s_l * t_h + t_l * s;
        p_h = lm_from_bitsf(lm_bitsf(u + v) & 0xfffff000u);
        p_l = v - (p_h - u);
        z_h = cp_h * p_h;
        z_l = cp_l * p_h + p_l * cp + dp_l[k];
        t = (float)n;
        t1 = lm_from_bitsf(lm_bitsf(((z_h + z_l) + dp_h[k]) + t) & 0xfffff000u);
        t2 = z_l - (((t1 - t) - dp_h[k]) - z_h);
    }
    y1 = lm_from_bitsf(lm_bitsf(y) & 0xfffff000u);
    p_l = (y - y1) * t1 + y * t2;
    p_h = y1 * t1;
    z = p_l + p_h;
    jz = lm_bitsf(z);
    if ((jz > 0x43000000u) && (jz < 0x80000000u)) {
        return sn * huge_value * huge_value;
    } else if (jz == 0x43000000u) {
        if ((p_l + ovt) > (z - p_h)) {
            return sn * huge_value * huge_value;
        }
    } else if ((jz & 0x7fffffffu) > 0x43160000u) {
        return sn * tiny * tiny;
    } else if ((jz == 0xc3160000u) && (p_l <= (z - p_h))) {
        return sn * tiny * tiny;
    } else {
        /* In range. */
    }
    i = (int32_t)(jz & 0x7fffffffu);
    k = (i >> 23) - 0x7f;
    n = 0;
    if (i > 0x3f000000) {
        uint32_t m = jz + (0x00800000u >> (k + 1));
        k = (int32_t)((m & 0x7fffffffu) >> 23) - 0x7f;
        t = lm_from_bitsf(m & ~(0x007fffffu >> k));
        m = ((m & 0x007fffffu) | 0x00800000u) >> (23 - k);
        n = (jz >= 0x80000000u) ? -(int32_t)m : (int32_t)m;
        p_h -= t;
    }
    t = lm_from_bitsf(lm_bitsf(p_l + p_h) & 0xffff8000u);
    u = t * lg2_h;
    v = (p_l - (t - p_h)) * lg2 + t * lg2_l;
    z = u + v;
    w = v - (z - u);
    t = z * z;
    t1 = z - t * (p1 + t * (p2 + t * (p3 + t * (p4 + t * p5))));
    r = (z * t1) / (t1 - 2.0f) - (w + z * w);
    z = 1.0f - (r - z);
    j = (int32_t)lm_bitsf(z) + n * 0x00800000;
    if (j < 0x00800000) {
        z = lm_scalbnf(z, n);
    } else {
        z = lm_from_bitsf((uint32_t)j);
    }
    return sn * z;
}
