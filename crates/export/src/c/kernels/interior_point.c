/* The primal-dual interior-point method of the moving-horizon estimator, where a bound is active. */
#ifndef HAS_BOUNDS
#define HAS_BOUNDS 1
#endif
#include "gauss_newton.c"

/* The larger of two numbers, the second where they are equal. */
static NUMBER larger(NUMBER x, NUMBER y)
{
    return (x > y) ? x : y;
}

/* Whether all states of a trajectory are within the bounds. */
static int is_within(int count, const NUMBER *x)
{
    int within = 1;
    int i;
    int k;
    for (i = 0; i < count; ++i) {
        for (k = 0; k < BOUND_COUNT; ++k) {
            const NUMBER entry = x[(i * STATES) + BOUNDED[k]];
            if ((SIDE[k] > REAL(0.0)) ? (!(BOUNDS[0][k] <= entry)) : (!(entry <= BOUNDS[0][k]))) {
                within = 0;
            }
        }
    }
    return within;
}

/* The trajectory with what violates a bound at the bound. */
static void clamp(int count, NUMBER *x)
{
    int i;
    int k;
    for (i = 0; i < count; ++i) {
        for (k = 0; k < BOUND_COUNT; ++k) {
            const int at = (i * STATES) + BOUNDED[k];
            if (SIDE[k] > REAL(0.0)) {
                x[at] = (x[at] > BOUNDS[0][k]) ? x[at] : BOUNDS[0][k];
            } else {
                x[at] = (x[at] < BOUNDS[0][k]) ? x[at] : BOUNDS[0][k];
            }
        }
    }
}

/* The steps of a slack and its multiplier, for the state in the solution and the bound number k. */
static void direction(NUMBER x, int k, const NUMBER *s, const NUMBER *z, NUMBER mu, NUMBER *steps)
{
    steps[0] = (SIDE[k] * (x - BOUNDS[0][k])) - *s;
    steps[1] = ((mu / *s) - *z) - ((*z / *s) * steps[0]);
}

/* The share of a step after which a positive number is still positive, at most alpha. */
static NUMBER shortened(NUMBER value, NUMBER step, NUMBER alpha)
{
    return ((value + (alpha * step)) < (LEFT_AT_BOUNDARY * value)) ? ((-FRACTION_TO_BOUNDARY * value) / step) : alpha;
}

/* The primal-dual interior-point method from x on, until its steps are small, and in a fixed number of them at most. */
static int interior(const observer_state *state, NUMBER *x, NUMBER *P)
{
    NUMBER s[WINDOW * BOUND_COUNT];
    NUMBER z[WINDOW * BOUND_COUNT];
    NUMBER solution[WINDOW * STATES];
    NUMBER deviation[STATES];
    NUMBER steps[2];
    const int pairs = state->count * BOUND_COUNT;
    NUMBER mu = REAL(1.0);
    int is_right = 1;
    int ends = 0;
    int step;
    int i;
    int k;

    for (k = 0; k < STATES; ++k) {
        deviation[k] = ROOT(larger(state->P[k][k], LEAST_VARIANCE));
    }
    clamp(state->count, x);
    for (i = 0; i < state->count; ++i) {
        for (k = 0; k < BOUND_COUNT; ++k) {
            const int j = BOUNDED[k];
            const NUMBER gap = SIDE[k] * (x[(i * STATES) + j] - BOUNDS[0][k]);
            s[(i * BOUND_COUNT) + k] = (MAGNITUDE(gap) <= LARGEST) ? larger(gap, deviation[j]) : REAL(1.0);
            z[(i * BOUND_COUNT) + k] = REAL(1.0) / s[(i * BOUND_COUNT) + k];
        }
    }
    for (step = 0; (step < INTERIOR_POINT_STEPS) && (is_right != 0) && (ends == 0); ++step) {
        is_right = pass(state, x, s, z, mu, solution, P);
        if (is_right != 0) {
            NUMBER alpha = REAL(1.0);
            NUMBER sum = REAL(0.0);
            NUMBER mean;
            NUMBER root;
            for (i = 0; i < state->count; ++i) {
                for (k = 0; k < BOUND_COUNT; ++k) {
                    const int at = (i * BOUND_COUNT) + k;
                    direction(solution[(i * STATES) + BOUNDED[k]], k, &s[at], &z[at], mu, steps);
                    alpha = shortened(s[at], steps[0], alpha);
                    alpha = shortened(z[at], steps[1], alpha);
                }
            }
            for (i = 0; i < state->count; ++i) {
                for (k = 0; k < BOUND_COUNT; ++k) {
                    const int at = (i * BOUND_COUNT) + k;
                    direction(solution[(i * STATES) + BOUNDED[k]], k, &s[at], &z[at], mu, steps);
                    s[at] = s[at] + (alpha * steps[0]);
                    z[at] = z[at] + (alpha * steps[1]);
                    sum = sum + (s[at] * z[at]);
                }
            }
            mean = sum / (NUMBER)pairs;
            root = ROOT(mean);
            ends = (mu <= LEAST_MU) ? 1 : 0;
            for (i = 0; i < state->count; ++i) {
                for (k = 0; k < STATES; ++k) {
                    const NUMBER change = solution[(i * STATES) + k] - x[(i * STATES) + k];
                    x[(i * STATES) + k] = x[(i * STATES) + k] + (alpha * change);
                    ends = (MAGNITUDE(change) <= (SMALL_STEP * deviation[k])) ? ends : 0;
                }
            }
            /* After a short step the centre is aimed at again; near the solution mu falls faster than in proportion. */
            mu = larger(((alpha > REAL(0.5)) ? ((root < TENTH) ? root : TENTH) : REAL(0.5)) * mean, LEAST_MU);
        }
    }
    clamp(state->count, x);
    return is_right;
}
