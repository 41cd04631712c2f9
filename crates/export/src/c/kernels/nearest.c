/* The search of a numerical KKL observer for the state whose image is nearest to the target state: the projected
 * Levenberg-Marquardt iteration on T by splines. The weights of several tables are shares, otherwise a null pointer. */
#include "spline_table.c"

/* The point of the box nearest to x; 0 in place of what is not finite. */
static void inside(NUMBER *x)
{
    int i;
    for (i = 0; i < STATES; ++i) {
        x[i] = between((MAGNITUDE(x[i]) <= LARGEST) ? x[i] : REAL(0.0), LOWER[i][0], UPPER[i][0]);
    }
}

/* The residual w - T(x) and the square of its length; the Jacobian of T is left in the last argument. */
static NUMBER residual_at(const NUMBER *shares, const NUMBER *w, const NUMBER *x, NUMBER *residual, NUMBER *jacobian)
{
    NUMBER sum;
    int i;

    table(shares, x, residual, jacobian);
    for (i = 0; i < TARGETS; ++i) {
        residual[i] = w[i] - residual[i];
    }
    sum = residual[0] * residual[0];
    for (i = 1; i < TARGETS; ++i) {
        sum = sum + (residual[i] * residual[i]);
    }
    return sum;
}

/* The step of (J'J + damping I) step = J'r, by Cholesky's factorisation; 0 where a pivot is not positive. */
static void solve(NUMBER g[STATES][STATES], NUMBER *right)
{
    int definite = 1;
    int i;
    int j;
    int k;

    for (j = 0; j < STATES; ++j) {
        for (i = j; i < STATES; ++i) {
            NUMBER entry = g[i][j];
            for (k = 0; k < j; ++k) {
                entry = entry - (g[i][k] * g[j][k]);
            }
            if (i > j) {
                g[i][j] = entry / g[j][j];
            } else if ((definite != 0) && (entry > REAL(0.0))) {
                g[j][j] = ROOT(entry);
            } else {
                g[j][j] = REAL(1.0);
                definite = 0;
            }
        }
    }
    for (i = 0; i < STATES; ++i) {
        for (k = 0; k < i; ++k) {
            right[i] = right[i] - (g[i][k] * right[k]);
        }
        right[i] = right[i] / g[i][i];
    }
    for (i = STATES - 1; i >= 0; --i) {
        for (k = i + 1; k < STATES; ++k) {
            right[i] = right[i] - (g[k][i] * right[k]);
        }
        right[i] = right[i] / g[i][i];
    }
    for (i = 0; (i < STATES) && (definite == 0); ++i) {
        right[i] = REAL(0.0);
    }
}

/* Moves x to a point of the box whose image is nearest to w, and returns the distance. */
static NUMBER nearest(const NUMBER *shares, const NUMBER *w, NUMBER *x)
{
    NUMBER residual[TARGETS];
    NUMBER jacobian[TARGETS * STATES];
    NUMBER damping = REAL(0.0);
    NUMBER cost;
    int done = 0;
    int evaluations;
    int i;
    int j;
    int k;

    inside(x);
    cost = residual_at(shares, w, x, residual, jacobian);
    for (evaluations = 1; (evaluations < MOST_EVALUATIONS) && (done == 0); ++evaluations) {
        NUMBER trial[TARGETS];
        NUMBER derivative[TARGETS * STATES];
        NUMBER gram[STATES][STATES];
        NUMBER step[STATES];
        NUMBER next[STATES];
        NUMBER trace;
        NUMBER moved = REAL(0.0);
        NUMBER trial_cost;
        for (i = 0; i < STATES; ++i) {
            step[i] = jacobian[i] * residual[0];
            for (k = 1; k < TARGETS; ++k) {
                step[i] = step[i] + (jacobian[(k * STATES) + i] * residual[k]);
            }
            for (j = 0; j < STATES; ++j) {
                gram[i][j] = jacobian[i] * jacobian[j];
                for (k = 1; k < TARGETS; ++k) {
                    gram[i][j] = gram[i][j] + (jacobian[(k * STATES) + i] * jacobian[(k * STATES) + j]);
                }
            }
        }
        trace = gram[0][0];
        for (i = 1; i < STATES; ++i) {
            trace = trace + gram[i][i];
        }
        for (i = 0; i < STATES; ++i) {
            /* At a face of the box, with the descent pointing out of it, a coordinate stands still. */
            if (((x[i] <= LOWER[i][0]) && (step[i] < REAL(0.0))) || ((x[i] >= UPPER[i][0]) && (step[i] > REAL(0.0)))) {
                for (j = 0; j < STATES; ++j) {
                    gram[i][j] = REAL(0.0);
                    gram[j][i] = REAL(0.0);
                }
                gram[i][i] = REAL(1.0);
                step[i] = REAL(0.0);
            } else {
                gram[i][i] = gram[i][i] + (damping + (trace * EPSILON));
            }
        }
        solve(gram, step);
        for (i = 0; i < STATES; ++i) {
            next[i] = x[i] + step[i];
        }
        inside(next);
        for (i = 0; i < STATES; ++i) {
            const NUMBER part = MAGNITUDE((next[i] - x[i]) / (UPPER[i][0] - LOWER[i][0]));
            moved = (moved > part) ? moved : part;
        }
        if (moved <= RESOLUTION) {
            done = 1;
        } else {
            trial_cost = residual_at(shares, w, next, trial, derivative);
            if (trial_cost < cost) {
                if ((cost - trial_cost) <= (RESOLUTION * cost)) {
                    done = 1;
                }
                for (i = 0; i < STATES; ++i) {
                    x[i] = next[i];
                }
                for (i = 0; i < TARGETS; ++i) {
                    residual[i] = trial[i];
                }
                for (i = 0; i < (TARGETS * STATES); ++i) {
                    jacobian[i] = derivative[i];
                }
                cost = trial_cost;
                damping = damping * LESS_DAMPING;
                if (damping < (trace * LEAST_DAMPING)) {
                    damping = REAL(0.0);
                }
            } else {
                const NUMBER more = damping * REAL(8.0);
                const NUMBER least = trace * FIRST_DAMPING;
                damping = (more > least) ? more : least;
            }
        }
    }
    return ROOT(cost);
}

#if HAS_RESTARTS
/* Moves x to the point of the box whose image is nearest to w: from x, and if the accuracy of the table does not
 * explain the distance, from the best points of a coarse grid. */
static void search(const NUMBER *shares, const NUMBER *w, NUMBER *x)
{
    NUMBER distance = nearest(shares, w, x);
    if (distance > TOLERANCE) {
        NUMBER costs[RESTARTS];
        NUMBER seeds[RESTARTS][STATES];
        int filled = 0;
        int cell;
        int i;
        int place;
        for (cell = 0; cell < GRID_CELLS; ++cell) {
            NUMBER residual[TARGETS];
            NUMBER jacobian[TARGETS * STATES];
            NUMBER seed[STATES];
            NUMBER cost;
            int rest = cell;
            int waiting = 1;
            for (i = 0; i < STATES; ++i) {
                seed[i] = LOWER[i][0] + ((UPPER[i][0] - LOWER[i][0]) * SHARE[rest % GRID_POINTS]);
                rest = rest / GRID_POINTS;
            }
            cost = residual_at(shares, w, seed, residual, jacobian);
            for (place = 0; (place < RESTARTS) && (waiting != 0); ++place) {
                if (place == filled) {
                    ++filled;
                    waiting = 0;
                    costs[place] = cost;
                    for (i = 0; i < STATES; ++i) {
                        seeds[place][i] = seed[i];
                    }
                } else if (cost < costs[place]) {
                    const NUMBER other = costs[place];
                    costs[place] = cost;
                    cost = other;
                    for (i = 0; i < STATES; ++i) {
                        const NUMBER entry = seeds[place][i];
                        seeds[place][i] = seed[i];
                        seed[i] = entry;
                    }
                } else {
                    /* The next place. */
                }
            }
        }
        for (place = 0; place < filled; ++place) {
            if (distance > TOLERANCE) {
                const NUMBER found = nearest(shares, w, seeds[place]);
                if (found < distance) {
                    distance = found;
                    for (i = 0; i < STATES; ++i) {
                        x[i] = seeds[place][i];
                    }
                }
            }
        }
    }
}
#endif
