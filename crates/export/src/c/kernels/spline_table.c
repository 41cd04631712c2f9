/* T by cubic B-splines, in its coordinates: on a grid with one table or one for each combination of the nodes of
 * held inputs, or as a product of matrices of low rank. The export defines the coefficients TABLE, the cells of the
 * grid, and the box from LOWER to UPPER. */
#include "between.c"

/* The four splines of each axis that are not zero at the point of the box nearest to x, and their slopes, four for each
 * axis; the number of the first of them. */
static void splines(const NUMBER *x, int *first, NUMBER *weights, NUMBER *slopes)
{
    int i;
    for (i = 0; i < STATES; ++i) {
        const NUMBER scale = (NUMBER)CELLS[i] / (UPPER[i][0] - LOWER[i][0]);
        const NUMBER position = (between(x[i], LOWER[i][0], UPPER[i][0]) - LOWER[i][0]) * scale;
        NUMBER *const w = &weights[4 * i];
        NUMBER *const v = &slopes[4 * i];
        NUMBER s;
        NUMBER r;
        first[i] = (int)position;
        if (first[i] > (CELLS[i] - 1)) {
            first[i] = CELLS[i] - 1;
        }
        s = position - (NUMBER)first[i];
        r = REAL(1.0) - s;
        w[0] = ((r * r) * r) * SIXTH;
        w[1] = TWO_THIRDS - ((s * s) * (REAL(1.0) - (REAL(0.5) * s)));
        w[2] = TWO_THIRDS - ((r * r) * (REAL(1.0) - (REAL(0.5) * r)));
        w[3] = ((s * s) * s) * SIXTH;
        v[0] = ((-REAL(0.5) * r) * r) * scale;
        v[1] = (s * ((REAL(1.5) * s) - REAL(2.0))) * scale;
        v[2] = (-r * ((REAL(1.5) * r) - REAL(2.0))) * scale;
        v[3] = ((REAL(0.5) * s) * s) * scale;
    }
}

#if LOW_RANK
/* T and its Jacobian: the product of the matrices, from the last axis to the first, with its derivatives by the axes
 * that it has passed. */
static void evaluate(const int *first, const NUMBER *weights, const NUMBER *slopes, NUMBER *value, NUMBER *jacobian)
{
    NUMBER product[MOST_RANK];
    NUMBER next[MOST_RANK];
    NUMBER gradient[STATES][MOST_RANK];
    NUMBER turned[STATES][MOST_RANK];
    int axis;
    int passed;
    int i;
    int j;

    product[0] = REAL(1.0);
    for (axis = STATES - 1; axis >= 0; --axis) {
        const int size = RANK[axis] * RANK[axis + 1];
        const NUMBER *const near = &TABLE[CORE[axis] + (first[axis] * size)];
        const NUMBER *const w = &weights[4 * axis];
        const NUMBER *const v = &slopes[4 * axis];
        for (i = 0; i < RANK[axis]; ++i) {
            next[i] = REAL(0.0);
            for (passed = axis; passed < STATES; ++passed) {
                turned[passed][i] = REAL(0.0);
            }
            for (j = 0; j < RANK[axis + 1]; ++j) {
                const NUMBER *const c = &near[(i * RANK[axis + 1]) + j];
                const NUMBER entry =
                    (((w[0] * c[0]) + (w[1] * c[size])) + (w[2] * c[2 * size])) + (w[3] * c[3 * size]);
                const NUMBER rate =
                    (((v[0] * c[0]) + (v[1] * c[size])) + (v[2] * c[2 * size])) + (v[3] * c[3 * size]);
                next[i] = next[i] + (entry * product[j]);
                turned[axis][i] = turned[axis][i] + (rate * product[j]);
                for (passed = axis + 1; passed < STATES; ++passed) {
                    turned[passed][i] = turned[passed][i] + (entry * gradient[passed][j]);
                }
            }
        }
        for (i = 0; i < RANK[axis]; ++i) {
            product[i] = next[i];
            for (passed = axis; passed < STATES; ++passed) {
                gradient[passed][i] = turned[passed][i];
            }
        }
    }
    for (i = 0; i < TARGETS; ++i) {
        value[i] = product[i];
        for (j = 0; j < STATES; ++j) {
            jacobian[(i * STATES) + j] = gradient[j][i];
        }
    }
}
#else
/* T and its Jacobian by one table: the sum over the coefficients near a point, along the last axis first, where they
 * stand one after the other. */
static void evaluate(const NUMBER *part, const int *first, const NUMBER *weights, const NUMBER *slopes, NUMBER *value,
                     NUMBER *jacobian)
{
    const NUMBER *const w = &weights[4 * (STATES - 1)];
    const NUMBER *const v = &slopes[4 * (STATES - 1)];
    int corner;
    int i;
    int j;

    for (i = 0; i < TARGETS; ++i) {
        value[i] = REAL(0.0);
        for (j = 0; j < STATES; ++j) {
            jacobian[(i * STATES) + j] = REAL(0.0);
        }
    }
    for (corner = 0; corner < CORNERS; ++corner) {
        const NUMBER *row;
        NUMBER line[TARGETS];
        NUMBER rise[TARGETS];
        NUMBER weight;
        int k[STATES];
        int rest = corner;
        int index = 0;
        k[STATES - 1] = 0;
        for (i = STATES - 2; i >= 0; --i) {
            k[i] = rest % 4;
            rest = rest / 4;
        }
        for (i = 0; i < STATES; ++i) {
            index = (index * STRIDE[i]) + first[i] + k[i];
        }
        row = &part[index * TARGETS];
        for (i = 0; i < TARGETS; ++i) {
            const NUMBER *const c = &row[i];
            line[i] = (((w[0] * c[0]) + (w[1] * c[TARGETS])) + (w[2] * c[2 * TARGETS])) + (w[3] * c[3 * TARGETS]);
            rise[i] = (((v[0] * c[0]) + (v[1] * c[TARGETS])) + (v[2] * c[2 * TARGETS])) + (v[3] * c[3 * TARGETS]);
        }
        /* The product of the weights of the axes before; for a derivative one of them is a slope. */
        weight = weights[k[0]];
        for (i = 1; i < (STATES - 1); ++i) {
            weight = weight * weights[(4 * i) + k[i]];
        }
        for (i = 0; i < TARGETS; ++i) {
            value[i] = value[i] + (weight * line[i]);
            jacobian[(i * STATES) + STATES - 1] = jacobian[(i * STATES) + STATES - 1] + (weight * rise[i]);
        }
        for (j = 0; j < (STATES - 1); ++j) {
            weight = (j == 0) ? slopes[k[0]] : weights[k[0]];
            for (i = 1; i < (STATES - 1); ++i) {
                weight = weight * ((j == i) ? slopes[(4 * i) + k[i]] : weights[(4 * i) + k[i]]);
            }
            for (i = 0; i < TARGETS; ++i) {
                jacobian[(i * STATES) + j] = jacobian[(i * STATES) + j] + (weight * line[i]);
            }
        }
    }
}
#endif

#if SEVERAL_TABLES
/* The weights of the tables at an input of the family: products of Lagrange's polynomials. */
static void share(const NUMBER *u, NUMBER *shares)
{
    int of;
    int i;
    int j;

    for (of = 0; of < TABLES; ++of) {
        int rest = of;
        shares[of] = REAL(1.0);
        for (i = INPUTS - 1; i >= 0; --i) {
            const int own = rest % NODE_COUNT;
            rest = rest / NODE_COUNT;
            for (j = 0; j < NODE_COUNT; ++j) {
                if (j != own) {
                    shares[of] = shares[of] * ((u[i] - NODES[i][j]) / (NODES[i][own] - NODES[i][j]));
                }
            }
        }
    }
}

/* T in its coordinates at the point of the box nearest to x, and its Jacobian, row by row: the sum over the tables with
 * these weights, all of which but one are zero at a node. */
static void table(const NUMBER *shares, const NUMBER *x, NUMBER *value, NUMBER *jacobian)
{
    NUMBER weights[STATES][4];
    NUMBER slopes[STATES][4];
    int first[STATES];
    int of;
    int i;

    splines(x, first, &weights[0][0], &slopes[0][0]);
    for (i = 0; i < TARGETS; ++i) {
        value[i] = REAL(0.0);
    }
    for (i = 0; i < (TARGETS * STATES); ++i) {
        jacobian[i] = REAL(0.0);
    }
    for (of = 0; of < TABLES; ++of) {
        if (shares[of] != REAL(0.0)) {
            NUMBER own[TARGETS];
            NUMBER derivative[TARGETS * STATES];
            evaluate(&TABLE[of * TABLE_SIZE], first, &weights[0][0], &slopes[0][0], own, derivative);
            for (i = 0; i < TARGETS; ++i) {
                value[i] = value[i] + (own[i] * shares[of]);
            }
            for (i = 0; i < (TARGETS * STATES); ++i) {
                jacobian[i] = jacobian[i] + (derivative[i] * shares[of]);
            }
        }
    }
}
#else
/* T in its coordinates at the point of the box nearest to x, and its Jacobian, row by row. */
static void table(const NUMBER *shares, const NUMBER *x, NUMBER *value, NUMBER *jacobian)
{
    NUMBER weights[STATES][4];
    NUMBER slopes[STATES][4];
    int first[STATES];

    (void)shares;
    splines(x, first, &weights[0][0], &slopes[0][0]);
#if LOW_RANK
    evaluate(first, &weights[0][0], &slopes[0][0], value, jacobian);
#else
    evaluate(TABLE, first, &weights[0][0], &slopes[0][0], value, jacobian);
#endif
}
#endif
