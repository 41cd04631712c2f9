/* The extended Kalman filter: update in Joseph's form, then prediction. The export defines motion (f and its Jacobian),
 * measurement (h and its Jacobian) and the covariances W and V; the state has xhat and its covariance P. */
#include "transition.c"
#include "innovation.c"
#include "angles.c"
#include "unit_vectors.c"

/* The gain K = P H' s^-1, transposed, from hp = H P and s = H P H' + V, which has its factor in place of its lower
 * triangle then; 0 if s is not positive definite in floating point. */
static int find_gain(const NUMBER *hp, NUMBER s[OUTPUTS][OUTPUTS], NUMBER gain[OUTPUTS][STATES])
{
    int definite = 1;
    int i;
    int j;
    int k;

    for (i = 0; i < OUTPUTS; ++i) {
        for (j = 0; j < OUTPUTS; ++j) {
            if (!(MAGNITUDE(s[i][j]) <= LARGEST)) {
                definite = 0;
            }
        }
    }
    if (definite != 0) {
        definite = factorise(s);
    }
    if (definite != 0) {
        for (j = 0; j < STATES; ++j) {
            for (i = 0; i < OUTPUTS; ++i) {
                NUMBER entry = hp[(i * STATES) + j];
                for (k = 0; k < i; ++k) {
                    entry = entry - (s[i][k] * gain[k][j]);
                }
                gain[i][j] = entry / s[i][i];
            }
            for (i = OUTPUTS - 1; i >= 0; --i) {
                NUMBER entry = gain[i][j];
                for (k = i + 1; k < OUTPUTS; ++k) {
                    entry = entry - (s[k][i] * gain[k][j]);
                }
                gain[i][j] = entry / s[i][i];
            }
        }
    }
    return definite;
}

/* xhat + K innovation. */
static void correct(const NUMBER *xhat, NUMBER gain[OUTPUTS][STATES], const NUMBER *innovation, NUMBER *estimate)
{
    int i;
    int k;

    for (i = 0; i < STATES; ++i) {
        NUMBER sum = gain[0][i] * innovation[0];
        for (k = 1; k < OUTPUTS; ++k) {
            sum = sum + (gain[k][i] * innovation[k]);
        }
        estimate[i] = xhat[i] + sum;
    }
}

/* The measurement update, in Joseph's form. The estimate stays as it is where there is no result: y is not finite, the
 * covariance of the innovation is not positive definite in floating point, or a number overflows. */
static void update(observer_state *state, NUMBER t, const NUMBER *u, const NUMBER *y)
{
    NUMBER all[OUTPUTS + (OUTPUTS * STATES)];
    const NUMBER *const H = &all[OUTPUTS];
    NUMBER innovation[OUTPUTS];
    NUMBER hp[OUTPUTS][STATES];
    NUMBER s[OUTPUTS][OUTPUTS];
    NUMBER gain[OUTPUTS][STATES]; /* transposed */
    NUMBER estimate[STATES];
    NUMBER keep[STATES][STATES];
    NUMBER kp[STATES][STATES];
    NUMBER next[STATES][STATES];
    NUMBER kv[STATES][OUTPUTS];
    NUMBER noise[OUTPUTS][OUTPUTS];
#if ITERATED
    NUMBER away[STATES];
    int turn;
#endif
#if PARTIAL
    int kept[OUTPUTS];
#endif
    int definite;
    int i;
    int j;
    int k;

    measurement(t, state->xhat, u, all);
    for (i = 0; i < OUTPUTS; ++i) {
#if ANGLES
        innovation[i] = wrap(y[i] - all[i], TURNS[0][i]);
#else
        innovation[i] = y[i] - all[i];
#endif
        for (j = 0; j < OUTPUTS; ++j) {
            noise[i][j] = V[i][j];
        }
    }
#if PARTIAL
    /* An output that is not finite, or whose innovation is beyond a gate or NaN, counts as not measured. */
    for (i = 0; i < OUTPUTS; ++i) {
        kept[i] = 0;
        if (MAGNITUDE(y[i]) <= LARGEST) {
            kept[i] = 1;
        }
    }
#if GATED
    spread_of_innovation(all, &state->P[0][0], &noise[0][0], &hp[0][0], &s[0][0]);
    for (i = 0; i < OUTPUTS; ++i) {
        if (!((innovation[i] * innovation[i]) <= (GATE_SQUARED * s[i][i]))) {
            kept[i] = 0;
        }
    }
#endif
    for (i = 0; i < OUTPUTS; ++i) {
        if (kept[i] == 0) {
            innovation[i] = REAL(0.0);
            for (j = 0; j < STATES; ++j) {
                all[OUTPUTS + (i * STATES) + j] = REAL(0.0);
            }
            for (j = 0; j < OUTPUTS; ++j) {
                noise[i][j] = REAL(0.0);
                noise[j][i] = REAL(0.0);
            }
            noise[i][i] = REAL(1.0);
        }
    }
#endif
    spread_of_innovation(all, &state->P[0][0], &noise[0][0], &hp[0][0], &s[0][0]);
    definite = find_gain(&hp[0][0], s, gain);
#if ITERATED
    /* Linearised again where the last linearisation leads, from the same prediction. */
    for (turn = 1; (turn < ITERATIONS) && (definite != 0); ++turn) {
        correct(state->xhat, gain, innovation, estimate);
        measurement(t, estimate, u, all);
        for (i = 0; i < STATES; ++i) {
            away[i] = state->xhat[i] - estimate[i];
        }
        for (i = 0; i < OUTPUTS; ++i) {
            NUMBER sum;
#if ANGLES
            innovation[i] = wrap(y[i] - all[i], TURNS[0][i]);
#else
            innovation[i] = y[i] - all[i];
#endif
#if PARTIAL
            if (kept[i] == 0) {
                innovation[i] = REAL(0.0);
                for (j = 0; j < STATES; ++j) {
                    all[OUTPUTS + (i * STATES) + j] = REAL(0.0);
                }
            }
#endif
            sum = H[i * STATES] * away[0];
            for (j = 1; j < STATES; ++j) {
                sum = sum + (H[(i * STATES) + j] * away[j]);
            }
            innovation[i] = innovation[i] - sum;
        }
        spread_of_innovation(all, &state->P[0][0], &noise[0][0], &hp[0][0], &s[0][0]);
        definite = find_gain(&hp[0][0], s, gain);
    }
#endif
    if (definite != 0) {
        /* I - K H. */
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = gain[0][i] * H[j];
                for (k = 1; k < OUTPUTS; ++k) {
                    sum = sum + (gain[k][i] * H[(k * STATES) + j]);
                }
                keep[i][j] = ((i == j) ? REAL(1.0) : REAL(0.0)) - sum;
            }
        }
        correct(state->xhat, gain, innovation, estimate);
        /* (I - K H) P (I - K H)' + K V K'. */
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = keep[i][0] * state->P[0][j];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (keep[i][k] * state->P[k][j]);
                }
                kp[i][j] = sum;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = kp[i][0] * keep[j][0];
                for (k = 1; k < STATES; ++k) {
                    sum = sum + (kp[i][k] * keep[j][k]);
                }
                next[i][j] = sum;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < OUTPUTS; ++j) {
                NUMBER sum = gain[0][i] * noise[0][j];
                for (k = 1; k < OUTPUTS; ++k) {
                    sum = sum + (gain[k][i] * noise[k][j]);
                }
                kv[i][j] = sum;
            }
        }
        for (i = 0; i < STATES; ++i) {
            for (j = 0; j < STATES; ++j) {
                NUMBER sum = kv[i][0] * gain[0][j];
                for (k = 1; k < OUTPUTS; ++k) {
                    sum = sum + (kv[i][k] * gain[k][j]);
                }
                next[i][j] = next[i][j] + sum;
            }
        }
        symmetrise(&next[0][0]);
        for (i = 0; i < STATES; ++i) {
            if (!(MAGNITUDE(estimate[i]) <= LARGEST)) {
                definite = 0;
            }
            for (j = 0; j < STATES; ++j) {
                if (!(MAGNITUDE(next[i][j]) <= LARGEST)) {
                    definite = 0;
                }
            }
        }
        for (i = 0; (i < STATES) && (definite != 0); ++i) {
            state->xhat[i] = estimate[i];
            for (j = 0; j < STATES; ++j) {
                state->P[i][j] = next[i][j];
            }
        }
#if HAS_UNIT_VECTORS
        if (definite != 0) {
            normalise(state);
        }
#endif
    }
}

/* The prediction for the next sample; NaN where it has no result in floating point. */
static void predict(observer_state *state, NUMBER t, const NUMBER *u)
{
    NUMBER z[STATES + (2 * STATES * STATES)];
    NUMBER next[STATES][STATES];
    int is_right = 1;
    int i;
    int j;

    linearise(t, state->xhat, u, z);
    spread(&state->P[0][0], z, &next[0][0]);
    for (i = 0; i < STATES; ++i) {
        if (!(MAGNITUDE(z[i]) <= LARGEST)) {
            is_right = 0;
        }
        for (j = 0; j < STATES; ++j) {
            if (!(MAGNITUDE(next[i][j]) <= LARGEST)) {
                is_right = 0;
            }
        }
    }
    for (i = 0; i < STATES; ++i) {
        state->xhat[i] = (is_right != 0) ? z[i] : (NUMBER)NAN;
        for (j = 0; (j < STATES) && (is_right != 0); ++j) {
            state->P[i][j] = next[i][j];
        }
    }
#if HAS_UNIT_VECTORS
    if (is_right != 0) {
        normalise(state);
    }
#endif
}
