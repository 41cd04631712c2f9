/* Polynomials on the cells of a tree of comparisons: each leaf has the centre and the inverse half-width of its
 * cell, the least and the greatest value of each output, and the coefficients of total degree DEGREE of each output.
 * TREE is the name of the function, HORNER that of a polynomial in VARIABLES variables; the nodes of the tree are
 * TREE_AXIS and so on, its leaves TREE_LEAVES. */
#include "between.c"
#include "horner_next.c"

/* Polynomials of total degree DEGREE, COEFFICIENTS coefficients each, on the cells of a tree. */
static void TREE(const NUMBER *point, NUMBER *out)
{
    NUMBER local[VARIABLES];
#if HAS_COMPARISONS
    int branch = 0;
    const NUMBER *leaf;
#else
    const NUMBER *const leaf = TREE_LEAVES;
#endif
    int i;
    int k = 2 * (VARIABLES + RESULTS);

#if HAS_COMPARISONS
    while (branch >= 0) {
        branch = (point[TREE_AXIS[branch]] < TREE_THRESHOLD[branch]) ? TREE_BELOW[branch] : TREE_ABOVE[branch];
    }
    leaf = &TREE_LEAVES[(-1 - branch) * LEAF_LENGTH];
#endif
    for (i = 0; i < VARIABLES; ++i) {
        local[i] = between((point[i] - leaf[i]) * leaf[VARIABLES + i], -REACH, REACH);
    }
    for (i = 0; i < RESULTS; ++i) {
        const NUMBER sum = HORNER(leaf, &k, local, DEGREE);
        out[i] = between(sum, leaf[(2 * VARIABLES) + i], leaf[(2 * VARIABLES) + RESULTS + i]);
    }
}
