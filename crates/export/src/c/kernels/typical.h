/* What an export defines before its kernels, for a small plant: with this header each kernel compiles on its own.
 * Options are 0 here; a compiler sets them with -D. */
#ifndef TYPICAL_H
#define TYPICAL_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>

/* The format of the numbers. */
#ifndef BINARY32
#define BINARY32 0
#endif
#if BINARY32
#define NUMBER float
#define REAL(x) x##f
#define ROOT sqrtf
#define MAGNITUDE fabsf
#define FLOOR floorf
#define LARGEST FLT_MAX
#else
#define NUMBER double
#define REAL(x) x
#define ROOT sqrt
#define MAGNITUDE fabs
#define FLOOR floor
#define LARGEST DBL_MAX
#endif

/* Sizes. */
#define STATES 2
#define INPUTS 2
#define OUTPUTS 2

/* Whether the plant has inputs, and whether it depends on the time; the period. */
#ifndef HAS_INPUTS
#define HAS_INPUTS 0
#endif
#ifndef TIMED
#define TIMED 0
#endif
#define PERIOD REAL(0.125)

/* A plant in discrete time has the next state for a slope. Otherwise a period has SUBSTEPS steps TAU of the Runge-Kutta
 * method; SEVERAL_STEPS is 1 for more than one. */
#ifndef DISCRETE
#define DISCRETE 0
#endif
#ifndef SEVERAL_STEPS
#define SEVERAL_STEPS 0
#endif
#define SUBSTEPS (1 + SEVERAL_STEPS)
#define TAU REAL(0.0625)
#define HALF_TAU REAL(0.03125)
#define QUARTER_TAU REAL(0.015625)
#define SIXTH_TAU REAL(0.0104166667)
#define THIRD REAL(0.333333333)

/* The times in a period that begins at t, at which nothing is added where the plant does not depend on the time: of
 * step number `step`, and in a step that begins at t of its middle and its end. */
#define T_STEP (t + (TAU * (NUMBER)step))
#define T_MIDDLE (t + HALF_TAU)
#define T_END (t + TAU)

/* The matrix of a feedback. */
extern const NUMBER K[INPUTS][STATES];

/* The filter form; the prediction over a varying time. */
#ifndef FILTER_FORM
#define FILTER_FORM 0
#endif
#define PARTS REAL(2.0)
#define PART_COUNT 2
#define SERIES_DEGREE 8

/* A gate at so many standard deviations of the innovation, squared. */
#ifndef GATED
#define GATED 0
#endif
#define GATE_SQUARED REAL(9.0)

/* Whether an update can leave out some of the outputs: of several, those that are not finite; with a gate, those that
 * it rejects. */
#ifndef PARTIAL
#define PARTIAL GATED
#endif

/* Whether outputs or states are angles, and their full turns. */
#ifndef ANGLES
#define ANGLES 0
#endif
extern const NUMBER TURNS[1][OUTPUTS];
extern const NUMBER STATE_TURNS[1][STATES];

/* Whether states form unit vectors, how many, and the number of that of each state. */
#ifndef HAS_UNIT_VECTORS
#define HAS_UNIT_VECTORS 0
#endif
#define VECTORS 1
extern const NUMBER UNIT_VECTORS[1][STATES];

/* Whether an update is linearised ITERATIONS times; once otherwise. */
#ifndef ITERATED
#define ITERATED 0
#endif

/* The sigma points of the unscented filter; whether the centre has a negative weight. */
#ifndef NEGATIVE_CENTRE
#define NEGATIVE_CENTRE 0
#endif
#define DISTANCE REAL(1.5)
#define OUTER_WEIGHT REAL(0.25)
#define HALF_WEIGHT REAL(0.5)
#define CENTRE_WEIGHT REAL(0.125)
#define NOISE_WEIGHT REAL(0.102062073)
#define TWICE_NOISE_WEIGHT REAL(0.204124145)

/* The window of the moving-horizon estimator, its Gauss-Newton steps, time and inputs of a sample where the plant
 * depends on them, its bounds and the constants of the interior-point method. */
#ifndef SEVERAL_SAMPLES
#define SEVERAL_SAMPLES 0
#endif
#define WINDOW (1 + (2 * SEVERAL_SAMPLES))
#define ITERATIONS 2
#ifndef DRIVEN
#define DRIVEN 0
#endif
#if DRIVEN
#define AT_TIME at->t
#define AT_INPUTS at->u
#else
#define AT_TIME REAL(0.0)
#define AT_INPUTS NULL
#endif
#ifndef HAS_BOUNDS
#define HAS_BOUNDS 0
#endif
#define BOUND_COUNT 2
extern const NUMBER BOUNDS[1][BOUND_COUNT];
extern const int BOUNDED[BOUND_COUNT];
extern const NUMBER SIDE[BOUND_COUNT];
#define INTERIOR_POINT_STEPS 12
#define LEAST_MU REAL(1e-4)
#define LEAST_VARIANCE REAL(1e-8)
#define SMALL_STEP REAL(1e-8)
#define FRACTION_TO_BOUNDARY REAL(0.995)
#define LEFT_AT_BOUNDARY REAL(0.005)
#define TENTH REAL(0.1)

/* What the state has besides the estimate. */
#ifndef HAS_COVARIANCE
#define HAS_COVARIANCE 0
#endif
#ifndef HAS_FACTOR
#define HAS_FACTOR 0
#endif
#ifndef HAS_WINDOW
#define HAS_WINDOW 0
#endif

/* The first estimate; the covariances of its error and of the noise, and their factors. */
extern const NUMBER INITIAL[STATES];
extern const NUMBER P0[STATES][STATES];
extern const NUMBER W[STATES][STATES];
extern const NUMBER V[OUTPUTS][OUTPUTS];
extern const NUMBER ROOT_P0[STATES][STATES];
extern const NUMBER ROOT_W[STATES][STATES];
extern const NUMBER ROOT_V[OUTPUTS][OUTPUTS];

/* The numerical KKL observer: its target states with their coordinates, the box of the estimate, the family of held
 * inputs, and the filter. */
#define TARGETS 3
extern const NUMBER B[TARGETS][OUTPUTS];
extern const NUMBER MEAN[TARGETS][1];
extern const NUMBER WHITEN[TARGETS][TARGETS];
extern const NUMBER COLOUR[TARGETS][TARGETS];
extern const NUMBER LOWER[STATES][1];
extern const NUMBER UPPER[STATES][1];
extern const NUMBER LEAST_INPUT[INPUTS][1];
extern const NUMBER MOST_INPUT[INPUTS][1];
extern const NUMBER FIRST_INPUT[INPUTS][1];
extern const NUMBER FILTER[TARGETS][TARGETS];

/* A tree of polynomials: variables and results, the degree of the polynomials, the numbers of a leaf, and the widths
 * of a cell from its centre at which a polynomial is held. */
void inverse(const NUMBER *point, NUMBER *out);
void forward(const NUMBER *point, NUMBER *out);
#ifndef HAS_COMPARISONS
#define HAS_COMPARISONS 0
#endif
#define TREE tree
#define HORNER horner_2
#define INNER horner_1
#define VARIABLE 1
#define VARIABLES 2
#define RESULTS 2
#define DEGREE 2
#define COEFFICIENTS 6
#define LEAF_LENGTH 20
#define REACH REAL(1.125)
extern const int TREE_AXIS[1];
extern const NUMBER TREE_THRESHOLD[1];
extern const int TREE_BELOW[1];
extern const int TREE_ABOVE[1];
extern const NUMBER TREE_LEAVES[2 * LEAF_LENGTH];

/* The splines of T: on a grid, of which the axes but the last have CORNERS combinations of splines near a point, or
 * of low rank; or several tables on a grid, one for each combination of the nodes of held inputs. */
#ifndef HAS_TABLE
#define HAS_TABLE 0
#endif
#ifndef SEVERAL_TABLES
#define SEVERAL_TABLES 0
#endif
#ifndef LOW_RANK
#define LOW_RANK 0
#elif SEVERAL_TABLES
#undef LOW_RANK
#define LOW_RANK 0
#endif
#define CORNERS 4
#define MOST_RANK 3
#define TABLES 4
#define TABLE_SIZE 48
#define NODE_COUNT 2
#define SIXTH REAL(0.166666667)
#define TWO_THIRDS REAL(0.666666667)
extern const int CELLS[STATES];
extern const int STRIDE[STATES];
extern const int RANK[STATES + 1];
extern const int CORE[STATES];
extern const NUMBER NODES[INPUTS][NODE_COUNT];
extern const NUMBER TABLE[TABLES * TABLE_SIZE];

/* The search in the table, with HAS_RESTARTS also from the best points of a coarse grid. */
#ifndef HAS_SEARCH
#define HAS_SEARCH 0
#endif
#ifndef HAS_RESTARTS
#define HAS_RESTARTS 0
#endif
#define MOST_EVALUATIONS 8
#define RESTARTS 3
#define GRID_POINTS 3
#define GRID_CELLS 9
#define TOLERANCE REAL(0.125)
#define EPSILON REAL(1e-7)
#define RESOLUTION REAL(4e-7)
#define FIRST_DAMPING REAL(1e-4)
#define LEAST_DAMPING REAL(1e-6)
#define LESS_DAMPING REAL(0.1)
extern const NUMBER SHARE[GRID_POINTS];

typedef struct {
    NUMBER x[STATES];
    NUMBER u[INPUTS];
    NUMBER y[OUTPUTS];
    NUMBER t;
    int measured[OUTPUTS];
} observer_sample;

typedef struct {
    NUMBER xhat[STATES];
    NUMBER P[STATES][STATES];
    NUMBER S[STATES][STATES];
    NUMBER z[TARGETS];
    NUMBER prediction[STATES];
    NUMBER innovation[OUTPUTS];
    NUMBER prior[STATES];
    NUMBER prior_P[STATES][STATES];
    observer_sample samples[WINDOW];
    int count;
    uint64_t sample;
} observer_state;

/* f, and its Jacobian row by row after it. MOTION is the function of the two that has both. */
void motion(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *out);
#define MOTION motion

/* What the Runge-Kutta method integrates. */
#define SLOPE motion
#define LENGTH (TARGETS + STATES)

/* h, and its Jacobian row by row after it. */
void measurement(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *out);

/* A recorded step: the next state; of a stationary filter y is the innovation. */
void advance(NUMBER t, const NUMBER *x, const NUMBER *u, const NUMBER *y, NUMBER *next);

/* Innovation and update of a stationary filter. */
void innovate(NUMBER t, const NUMBER *x, const NUMBER *u, const NUMBER *y, const NUMBER *before, NUMBER *innovation);
void updated(NUMBER t, const NUMBER *x, const NUMBER *innovation, NUMBER *xhat);

/* What is recorded of an observer at varying periods. */
void first_term(NUMBER t, const NUMBER *x, const NUMBER *u, const NUMBER *tau, const NUMBER *degree, NUMBER *next);
void next_term(NUMBER t, const NUMBER *x, const NUMBER *u, const NUMBER *tau, const NUMBER *degree, NUMBER *next);
void corrected(NUMBER t, const NUMBER *x, const NUMBER *u, const NUMBER *y, NUMBER *next);

/* The measured minus the expected output. */
void output_error(NUMBER t, const NUMBER *x, const NUMBER *u, const NUMBER *y, NUMBER *innovation);

/* A recorded observer of ORDER states: its right-hand side, estimate, jump and start, and the time of the estimate. */
#define ORDER TARGETS
#define T_ESTIMATE (t + PERIOD)
#ifndef HAS_JUMP
#define HAS_JUMP 0
#endif
#ifndef STARTS_WITH_OUTPUT
#define STARTS_WITH_OUTPUT 0
#endif
void rate(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *out);
void estimate(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *out);
void jump(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *out);
void start(NUMBER t, const NUMBER *x, const NUMBER *u, NUMBER *out);

/* The step around which a feedback is. */
void observe(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat);

#endif
