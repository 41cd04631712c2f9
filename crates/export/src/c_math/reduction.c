/* FreeBSD msun k_rem_pio2.c: 396 hexadecimal digits of 2/pi. */
static const int32_t lm_two_over_pi[66] = {
    0xA2F983, 0x6E4E44, 0x1529FC, 0x2757D1, 0xF534DD, 0xC0DB62, 0x95993C, 0x439041, 0xFE5163, 0xABDEBB, 0xC561B7,
    0x246E3A, 0x424DD2, 0xE00649, 0x2EEA09, 0xD1921C, 0xFE1DEB, 0x1CB129, 0xA73EE8, 0x8235F5, 0x2EBB44, 0x84E99C,
    0x7026B4, 0x5F7E41, 0x3991D6, 0x398353, 0x39F49C, 0x845F8B, 0xBDF928, 0x3B1FF8, 0x97FFDE, 0x05980F, 0xEF2F11,
    0x8B5A0A, 0x6D1F6D, 0x367ECF, 0x27CB09, 0xB74F46, 0x3F669E, 0x5FEA2D, 0x7527BA, 0xC7EBE5, 0xF17B3D, 0x0739F7,
    0x8A5292, 0xEA6BFB, 0x5FB11F, 0x8D5D08, 0x560330, 0x46FC7B, 0x6BABF0, 0xCFBC20, 0x9AF436, 0x1DA9E3, 0x91615E,
    0xE61B08, 0x659985, 0x5F14A0, 0x68408D, 0xFFD880, 0x4D7327, 0x310606, 0x1556CA, 0x73A8C9, 0x60E27B, 0xC08C6B,
};

/* FreeBSD msun k_rem_pio2.c: pi/2 in pieces of 24 bits. */
static const double lm_pio2_pieces[8] = {
    0x1.921fb4p+0, 0x1.4442dp-24, 0x1.846988p-48, 0x1.8cc516p-72,
    0x1.01b838p-96, 0x1.a25204p-120, 0x1.382228p-145, 0x1.9f31dp-169,
};

/* FreeBSD msun k_rem_pio2.c, for large arguments: the argument is the sum of x[i] 2^(e0 - 24 i), i = 0..jx. Returns the
 * last three bits of N, and y = argument - N pi/2 in two pieces. */
static int32_t lm_rem_pio2_large(const double *x, int32_t jx, double *y, int32_t e0)
{
    const int32_t jk = 4;
    const int32_t jp = jk;
    double f[20] = {0.0};
    double fq[20] = {0.0};
    double q[20] = {0.0};
    int32_t iq[20] = {0};
    double fw;
    double z;
    int32_t n;
    int32_t ih;
    int32_t i;
    int32_t j;
    int32_t k;
    int32_t jz = jk;
    int again = 1;
    int32_t jv = (e0 - 3) / 24;
    int32_t q0;
    if (jv < 0) {
        jv = 0;
    }
    q0 = e0 - 24 * (jv + 1);
    for (i = 0; i <= (jx + jk); ++i) {
        j = jv - jx + i;
        f[i] = (j < 0) ? 0.0 : (double)lm_two_over_pi[j];
    }
    for (i = 0; i <= jk; ++i) {
        fw = 0.0;
        for (j = 0; j <= jx; ++j) {
            fw += x[j] * f[jx + i - j];
        }
        q[i] = fw;
    }
    do {
        again = 0;
        i = 0;
        z = q[jz];
        for (j = jz; j >= 1; --j) {
            fw = (double)(int32_t)(0x1p-24 * z);
            iq[i] = (int32_t)(z - 0x1p+24 * fw);
            z = q[j - 1] + fw;
            ++i;
        }
        z = lm_scalbn(z, q0);
        z -= 8.0 * floor(z * 0.125);
        n = (int32_t)z;
        z -= (double)n;
        ih = 0;
        if (q0 > 0) {
            i = iq[jz - 1] >> (24 - q0);
            n += i;
            iq[jz - 1] -= i << (24 - q0);
            ih = iq[jz - 1] >> (23 - q0);
        } else if (q0 == 0) {
            ih = iq[jz - 1] >> 23;
        } else if (z >= 0.5) {
            ih = 2;
        } else {
            /* The fraction is below 1/2. */
        }
        if (ih > 0) {
            int carry = 0;
            n += 1;
            for (i = 0; i < jz; ++i) {
                j = iq[i];
                if (carry == 0) {
                    if (j != 0) {
                        carry = 1;
                        iq[i] = 0x1000000 - j;
                    }
                } else {
                    iq[i] = 0xffffff - j;
                }
            }
            if (q0 == 1) {
                iq[jz - 1] &= 0x7fffff;
            } else if (q0 == 2) {
                iq[jz - 1] &= 0x3fffff;
            } else {
                /* No bits to clear. */
            }
            if (ih == 2) {
                z = 1.0 - z;
                if (carry != 0) {
                    z -= lm_scalbn(1.0, q0);
                }
            }
        }
        if (z == 0.0) {
            j = 0;
            for (i = jz - 1; i >= jk; --i) {
                j |= iq[i];
            }
            if (j == 0) {
                k = 1;
                while (iq[jk - k] == 0) {
                    ++k;
                }
                for (i = jz + 1; i <= (jz + k); ++i) {
                    f[jx + i] = (double)lm_two_over_pi[jv + i];
                    fw = 0.0;
                    for (j = 0; j <= jx; ++j) {
                        fw += x[j] * f[jx + i - j];
                    }
                    q[i] = fw;
                }
                jz += k;
                again = 1;
            }
        }
    } while (again != 0);
    if (z == 0.0) {
        jz -= 1;
        q0 -= 24;
        while (iq[jz] == 0) {
            jz -= 1;
            q0 -= 24;
        }
    } else {
        z = lm_scalbn(z, -q0);
        if (z >= 0x1p+24) {
            fw = (double)(int32_t)(0x1p-24 * z);
            iq[jz] = (int32_t)(z - 0x1p+24 * fw);
            jz += 1;
            q0 += 24;
            iq[jz] = (int32_t)fw;
        } else {
            iq[jz] = (int32_t)z;
        }
    }
    fw = lm_scalbn(1.0, q0);
    for (i = jz; i >= 0; --i) {
        q[i] = fw * (double)iq[i];
        fw *= 0x1p-24;
    }
    for (i = jz; i >= 0; --i) {
        fw = 0.0;
        for (k = 0; (k <= jp) && (k <= (jz - i)); ++k) {
            fw += lm_pio2_pieces[k] * q[i + k];
        }
        fq[jz - i] = fw;
    }
    fw = 0.0;
    for (i = jz; i >= 0; --i) {
        fw += fq[i];
    }
    y[0] = (ih == 0) ? fw : -fw;
    fw = fq[0] - fw;
    for (i = 1; i <= jz; ++i) {
        fw += fq[i];
    }
    y[1] = (ih == 0) ? fw : -fw;
    return (int32_t)((uint32_t)n & 7u);
}

/* FreeBSD msun e_rem_pio2.c, for |x| below 2^20 pi/2: N = rint(x 2/pi), and x - N pi/2 in two pieces. */
static int32_t lm_rem_pio2_medium(double x, uint32_t ix, double *y)
{
    const double to_int = 1.5 / 0x1p-52;
    const double inv_pio2 = 0x1.45f306dc9c883p-1;
    const double pio2_1 = 0x1.921fb544p+0;
    const double pio2_1t = 0x1.0b4611a626331p-34;
    const double pio2_2 = 0x1.0b4611a6p-34;
    const double pio2_2t = 0x1.3198a2e037073p-69;
    const double pio2_3 = 0x1.3198a2ep-69;
    const double pio2_3t = 0x1.b839a252049c1p-104;
    const double shifted = x * inv_pio2 + to_int;
    const double f_n = shifted - to_int;
    const int32_t ex = (int32_t)(ix >> 20);
    double r = x - f_n * pio2_1;
    double w = f_n * pio2_1t;
    double y0 = r - w;
    int32_t ey = (int32_t)((lm_high(y0) >> 20) & 0x7ffu);
    if ((ex - ey) > 16) {
        double t = r;
        w = f_n * pio2_2;
        r = t - w;
        w = f_n * pio2_2t - ((t - r) - w);
        y0 = r - w;
        ey = (int32_t)((lm_high(y0) >> 20) & 0x7ffu);
        if ((ex - ey) > 49) {
            t = r;
            w = f_n * pio2_3;
            r = t - w;
            w = f_n * pio2_3t - ((t - r) - w);
            y0 = r - w;
        }
    }
    y[0] = y0;
    y[1] = (r - y0) - w;
    return (int32_t)f_n;
}

/* FreeBSD msun e_rem_pio2.c: N and y = x - N pi/2 in two pieces, |y| <= pi/4, for finite x beyond pi/4. */
static int32_t lm_rem_pio2(double x, double *y)
{
    const double pio2_1 = 0x1.921fb544p+0;
    const double pio2_1t = 0x1.0b4611a626331p-34;
    const int negative = (lm_high(x) >> 31) != 0u;
    const uint32_t ix = lm_high(x) & 0x7fffffffu;
    double pieces[3];
    double z;
    int32_t n;
    int32_t i;
    if (ix <= 0x401c463bu) {
        double multiple;
        if (ix <= 0x400f6a7au) {
            if ((ix & 0xfffffu) == 0x921fbu) {
                return lm_rem_pio2_medium(x, ix, y);
            }
            n = (ix <= 0x4002d97cu) ? 1 : 2;
        } else {
            if ((ix == 0x4012d97cu) || (ix == 0x401921fbu)) {
                return lm_rem_pio2_medium(x, ix, y);
            }
            n = (ix <= 0x4015fdbcu) ? 3 : 4;
        }
        multiple = (double)n;
        if (!negative) {
            z = x - multiple * pio2_1;
            y[0] = z - multiple * pio2_1t;
            y[1] = (z - y[0]) - multiple * pio2_1t;
            return n;
        }
        z = x + multiple * pio2_1;
        y[0] = z + multiple * pio2_1t;
        y[1] = (z - y[0]) + multiple * pio2_1t;
        return -n;
    }
    if (ix < 0x413921fbu) {
        return lm_rem_pio2_medium(x, ix, y);
    }
    z = lm_from_bits((lm_bits(x) & 0x000fffffffffffffu) | ((uint64_t)(0x3ff + 23) << 52));
    for (i = 0; i < 2; ++i) {
        pieces[i] = (double)(int32_t)z;
        z = (z - pieces[i]) * 0x1p+24;
    }
    pieces[2] = z;
    i = 2;
    while ((i != 0) && (pieces[i] == 0.0)) {
        --i;
    }
    n = lm_rem_pio2_large(pieces, i, y, (int32_t)(ix >> 20) - (0x3ff + 23));
    if (negative) {
        y[0] = -y[0];
        y[1] = -y[1];
        return -n;
    }
    return n;
}

/* The bits of 2/pi, after 32 bits before the point. */
static const uint32_t lm_two_over_pif[8] = {
    0x00000000u, 0xa2f9836eu, 0x4e441529u, 0xfc2757d1u, 0xf534ddc0u, 0xdb629599u, 0x3c439041u, 0xfe5163abu,
};

/* For finite x from 402: N modulo 4, and x - N pi/2 in two pieces. By Payne and Hanek: x 2/pi modulo 4 from the 96 bits
 * of 2/pi that decide it, in integers. The fraction of a turn is at least 2^-32. */
static uint32_t lm_rem_pio2_largef(float x, float *y)
{
    const uint32_t ix = lm_bitsf(x);
    const uint32_t m = (ix & 0x007fffffu) | 0x00800000u;
    const uint32_t first = (ix >> 23) - 120u;
    const uint32_t word = first >> 5;
    const uint32_t shift = 32u - (first & 31u);
    uint32_t piece[3];
    uint64_t quarters;
    uint64_t part;
    uint32_t zeros = 0u;
    uint32_t n;
    uint32_t k;
    int32_t v;
    float scale;
    for (k = 0u; k < 3u; ++k) {
        const uint64_t two = ((uint64_t)lm_two_over_pif[word + k] << 32) | (uint64_t)lm_two_over_pif[word + k + 1u];
        piece[k] = (uint32_t)((two >> shift) & 0xffffffffu);
    }
    quarters = (uint64_t)m * (uint64_t)piece[0];
    quarters = (quarters << 32) + (uint64_t)m * (uint64_t)piece[1] + (((uint64_t)m * (uint64_t)piece[2]) >> 32);
    n = (uint32_t)((quarters + 0x2000000000000000u) >> 62) & 3u;
    part = quarters << 2;
    scale = ((part >> 63) != 0u) ? -1.0f : 1.0f;
    if ((part >> 63) != 0u) {
        part = 0u - part;
    }
    for (k = 0u; (k < 34u) && ((part >> 63) == 0u); ++k) {
        part <<= 1;
        ++zeros;
    }
    scale *= lm_from_bitsf((98u - zeros) << 23);
    v = (int32_t)(((part >> 32) * 0xc90fdaa2u) >> 34);
    y[0] = (float)v;
    y[1] = (float)(v - (int32_t)y[0]) * scale;
    y[0] *= scale;
    return n;
}

/* N = rint(x 2/pi) modulo 4 and x - N pi/2 in two pieces, for finite x from pi/4. Below 402, N has 8 bits, and the first
 * two parts of pi/2 have 16 bits each: their products with N are exact, and so is the first difference. */
static uint32_t lm_rem_pio2f(float x, float *y)
{
    const float inv_pio2 = 0x1.45f306p-1f;
    const float pio2_1 = 0x1.921ep+0f;
    const float pio2_2 = 0x1.b544p-16f;
    const float pio2_3 = 0x1.0b4612p-34f;
    uint32_t n;
    float f_n;
    float t;
    float r;
    float w;
    if (x >= 402.0f) {
        return lm_rem_pio2_largef(x, y);
    }
    n = (uint32_t)(x * inv_pio2 + 0.5f);
    f_n = (float)n;
    t = x - f_n * pio2_1;
    w = f_n * pio2_2;
    r = t - w;
    w = ((t - r) - w) - f_n * pio2_3;
    y[0] = r + w;
    y[1] = (r - y[0]) + w;
    return n & 3u;
}
