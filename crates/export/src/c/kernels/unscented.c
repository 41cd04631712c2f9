/* The unscented Kalman filter in square-root form. The export defines motion (f), measurement (h), centre (f and its
 * Jacobian, in continuous time), and the factors ROOT_W and ROOT_V of the covariances; the state has xhat and the
 * factor S of its covariance. The weights are those of UnscentedKalmanFilter in Rust. */
#include "typical.h"
#include "angles.c"
#if DISCRETE
#include "columns.c"
#else
#include "runge_kutta.c"
#include "noise.c"
#endif

/* A sigma point: column k of s, distance times, added to x. */
static void sigma_point(const NUMBER *x, const NUMBER *s, NUMBER distance, int k, NUMBER *point)
{
    int i;
    for (i = 0; i < STATES; ++i) {
        point[i] = x[i];
    }
    for (i = k; i < STATES; ++i) {
        point[i] = x[i] + (distance * s[(i * STATES) + k]);
    }
}

#if ANGLES
/* One entry of the images, an angle: each is less than half a turn from that of the centre. */
static void approach(NUMBER *plus, NUMBER *minus, NUMBER first, NUMBER turn)
{
    int k;
    for (k = 0; (k < STATES) && (turn > REAL(0.0)); ++k) {
        plus[k] = first + wrap(plus[k] - first, turn);
        minus[k] = first + wrap(minus[k] - first, turn);
    }
}
#endif

/* The mean of one entry of the images. Left are that entry of the half differences and sums, and of the centre. */
static NUMBER reduce(NUMBER *plus, NUMBER *minus, NUMBER *middle)
{
    const NUMBER first = *middle;
    NUMBER twice = REAL(2.0) * first;
    NUMBER sum = REAL(0.0);
    NUMBER mean;
    int k;
    for (k = 0; k < STATES; ++k) {
        sum = sum + ((plus[k] + minus[k]) - twice);
    }
    mean = first + (OUTER_WEIGHT * sum);
    twice = REAL(2.0) * mean;
    for (k = 0; k < STATES; ++k) {
        const NUMBER above = plus[k];
        const NUMBER below = minus[k];
        plus[k] = HALF_WEIGHT * (above - below);
        minus[k] = HALF_WEIGHT * ((above + below) - twice);
    }
    *middle = CENTRE_WEIGHT * (first - mean);
    return mean;
}

/* The measurement that is expected, and the factor [g, 0; m, s] of its covariance and that of the state together; 0 if
 * there is none in floating point. */
static int joint(const observer_state *state, NUMBER t, const NUMBER *u,
#if PARTIAL
                 const int *kept,
#endif
                 NUMBER *expected, NUMBER *g, NUMBER *m, NUMBER *s)
{
    NUMBER middle[OUTPUTS];
    NUMBER plus[OUTPUTS][STATES];
    NUMBER minus[OUTPUTS][STATES];
    NUMBER point[STATES];
    NUMBER image[OUTPUTS];
    NUMBER column[OUTPUTS];
    NUMBER rest[STATES];
    int is_right = 1;
    int i;
    int k;

    measurement(t, state->xhat, u, middle);
    for (k = 0; k < STATES; ++k) {
        sigma_point(state->xhat, &state->S[0][0], DISTANCE, k, point);
        measurement(t, point, u, image);
        for (i = 0; i < OUTPUTS; ++i) {
            plus[i][k] = image[i];
        }
        sigma_point(state->xhat, &state->S[0][0], -DISTANCE, k, point);
        measurement(t, point, u, image);
        for (i = 0; i < OUTPUTS; ++i) {
            minus[i][k] = image[i];
        }
    }
    for (i = 0; i < OUTPUTS; ++i) {
#if ANGLES
        approach(plus[i], minus[i], middle[i], TURNS[0][i]);
#endif
        expected[i] = reduce(plus[i], minus[i], &middle[i]);
        for (k = 0; k < OUTPUTS; ++k) {
            g[(i * OUTPUTS) + k] = ROOT_V[i][k];
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (k = 0; k < OUTPUTS; ++k) {
            m[(i * OUTPUTS) + k] = REAL(0.0);
        }
        for (k = 0; k < STATES; ++k) {
            s[(i * STATES) + k] = REAL(0.0);
        }
    }
#if PARTIAL
    /* An output that is not kept has the noise 1 and no part in the innovation. */
    for (i = 0; i < OUTPUTS; ++i) {
        if (kept[i] == 0) {
            middle[i] = REAL(0.0);
            for (k = 0; k < STATES; ++k) {
                plus[i][k] = REAL(0.0);
                minus[i][k] = REAL(0.0);
            }
            for (k = 0; k < OUTPUTS; ++k) {
                g[(i * OUTPUTS) + k] = REAL(0.0);
                column[k] = REAL(0.0);
            }
            column[i] = REAL(1.0);
            add(g, column, OUTPUTS);
        }
    }
#endif
    for (k = 0; k < STATES; ++k) {
        for (i = 0; i < OUTPUTS; ++i) {
            column[i] = minus[i][k];
        }
        add(g, column, OUTPUTS);
    }
    for (k = 0; k < STATES; ++k) {
        for (i = 0; i < OUTPUTS; ++i) {
            column[i] = plus[i][k];
        }
        for (i = 0; i < STATES; ++i) {
            rest[i] = state->S[i][k];
        }
        add_joint(g, m, s, column, rest);
    }
    for (i = 0; i < STATES; ++i) {
        rest[i] = REAL(0.0);
    }
#if NEGATIVE_CENTRE
    is_right = subtract_joint(g, m, s, middle, rest);
#else
    add_joint(g, m, s, middle, rest);
#endif
    for (i = 0; i < OUTPUTS; ++i) {
        if (!(g[(i * OUTPUTS) + i] > REAL(0.0))) {
            is_right = 0;
        }
        for (k = 0; k < OUTPUTS; ++k) {
            if (!(MAGNITUDE(g[(i * OUTPUTS) + k]) <= LARGEST)) {
                is_right = 0;
            }
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (k = 0; k < OUTPUTS; ++k) {
            if (!(MAGNITUDE(m[(i * OUTPUTS) + k]) <= LARGEST)) {
                is_right = 0;
            }
        }
        for (k = 0; k < STATES; ++k) {
            if (!(MAGNITUDE(s[(i * STATES) + k]) <= LARGEST)) {
                is_right = 0;
            }
        }
    }
    return is_right;
}

/* The measurement update. The estimate stays as it is where there is no result: y is not finite, the covariances
 * have no factor in floating point, or a number overflows. */
static void update(observer_state *state, NUMBER t, const NUMBER *u, const NUMBER *y)
{
    NUMBER expected[OUTPUTS];
    NUMBER value[OUTPUTS];
    NUMBER g[OUTPUTS][OUTPUTS];
    NUMBER m[STATES][OUTPUTS];
    NUMBER s[STATES][STATES];
    NUMBER estimate[STATES];
#if PARTIAL
    int kept[OUTPUTS];
#endif
    int is_right;
    int i;
    int k;

#if PARTIAL
    for (i = 0; i < OUTPUTS; ++i) {
#if GATED
        kept[i] = 1;
#else
        /* An output that is not finite counts as not measured. */
        kept[i] = 0;
        if (MAGNITUDE(y[i]) <= LARGEST) {
            kept[i] = 1;
        }
#endif
    }
    is_right = joint(state, t, u, kept, expected, &g[0][0], &m[0][0], &s[0][0]);
#else
    is_right = joint(state, t, u, expected, &g[0][0], &m[0][0], &s[0][0]);
#endif
    for (i = 0; i < OUTPUTS; ++i) {
#if ANGLES
        value[i] = wrap(y[i] - expected[i], TURNS[0][i]);
#else
        value[i] = y[i] - expected[i];
#endif
    }
#if GATED
    /* An output whose innovation is beyond the gate, or NaN, counts as not measured. */
    for (i = 0; (i < OUTPUTS) && (is_right != 0); ++i) {
        NUMBER variance = REAL(0.0);
        for (k = 0; k <= i; ++k) {
            variance = variance + (g[i][k] * g[i][k]);
        }
        if (!((value[i] * value[i]) <= (GATE_SQUARED * variance))) {
            kept[i] = 0;
        }
    }
    if (is_right != 0) {
        is_right = joint(state, t, u, kept, expected, &g[0][0], &m[0][0], &s[0][0]);
    }
#endif
#if PARTIAL
    for (i = 0; i < OUTPUTS; ++i) {
        if (kept[i] == 0) {
            value[i] = REAL(0.0);
        }
    }
#endif
    if (is_right != 0) {
        for (i = 0; i < OUTPUTS; ++i) {
            for (k = 0; k < i; ++k) {
                value[i] = value[i] - (g[i][k] * value[k]);
            }
            value[i] = value[i] / g[i][i];
        }
        for (i = 0; i < STATES; ++i) {
            estimate[i] = state->xhat[i];
            for (k = 0; k < OUTPUTS; ++k) {
                estimate[i] = estimate[i] + (m[i][k] * value[k]);
            }
            if (!(MAGNITUDE(estimate[i]) <= LARGEST)) {
                is_right = 0;
            }
        }
    }
    for (i = 0; (i < STATES) && (is_right != 0); ++i) {
        state->xhat[i] = estimate[i];
        for (k = 0; k < STATES; ++k) {
            state->S[i][k] = s[i][k];
        }
    }
}

#if DISCRETE
/* A sigma point at the next sample. */
static void move(NUMBER t, const NUMBER *u, NUMBER *z)
{
    NUMBER next[STATES];
    int i;
    motion(t, z, u, next);
    for (i = 0; i < STATES; ++i) {
        z[i] = next[i];
    }
}
#endif

/* The prediction for the next sample; NaN where its covariance has no factor in floating point. */
static void predict(observer_state *state, NUMBER t, const NUMBER *u)
{
    NUMBER next[STATES][STATES];
    NUMBER middle[STATES];
    NUMBER plus[STATES][STATES];
    NUMBER minus[STATES][STATES];
    NUMBER column[STATES];
    NUMBER mean[STATES];
    int is_right = 1;
    int i;
    int k;

    for (i = 0; i < STATES; ++i) {
        middle[i] = state->xhat[i];
    }
#if DISCRETE
    for (i = 0; i < STATES; ++i) {
        for (k = 0; k < STATES; ++k) {
            next[i][k] = ROOT_W[i][k];
        }
    }
#else
    noise(t, state->xhat, u, &next[0][0]);
#endif
    move(t, u, middle);
    for (k = 0; k < STATES; ++k) {
        sigma_point(state->xhat, &state->S[0][0], DISTANCE, k, column);
        move(t, u, column);
        for (i = 0; i < STATES; ++i) {
            plus[i][k] = column[i];
        }
        sigma_point(state->xhat, &state->S[0][0], -DISTANCE, k, column);
        move(t, u, column);
        for (i = 0; i < STATES; ++i) {
            minus[i][k] = column[i];
        }
    }
    for (i = 0; i < STATES; ++i) {
#if ANGLES
        approach(plus[i], minus[i], middle[i], STATE_TURNS[0][i]);
#endif
        mean[i] = reduce(plus[i], minus[i], &middle[i]);
    }
    for (k = 0; k < STATES; ++k) {
        for (i = 0; i < STATES; ++i) {
            column[i] = minus[i][k];
        }
        add(&next[0][0], column, STATES);
    }
    for (k = 0; k < STATES; ++k) {
        for (i = 0; i < STATES; ++i) {
            column[i] = plus[i][k];
        }
        add(&next[0][0], column, STATES);
    }
#if NEGATIVE_CENTRE
    is_right = subtract(&next[0][0], middle, STATES);
#else
    add(&next[0][0], middle, STATES);
#endif
    for (i = 0; i < STATES; ++i) {
        if (!(MAGNITUDE(mean[i]) <= LARGEST)) {
            is_right = 0;
        }
        for (k = 0; k < STATES; ++k) {
            if (!(MAGNITUDE(next[i][k]) <= LARGEST)) {
                is_right = 0;
            }
        }
    }
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = (is_right != 0) ? mean[i] : (NUMBER)NAN;
        for (k = 0; (k < STATES) && (is_right != 0); ++k) {
            state->S[i][k] = (k <= i) ? next[i][k] : REAL(0.0);
        }
    }
}
