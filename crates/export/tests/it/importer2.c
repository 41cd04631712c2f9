/* Imports an FMU 2.0 that is linked to it. Exit code 0 if all is as it should be. */
#include "vectors.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

const char *fmi2GetVersion(void);
void *fmi2Instantiate(const char *, int, const char *, const char *, const callbacks *, int, int);
void fmi2FreeInstance(void *);
int fmi2SetupExperiment(void *, int, double, double, int, double);
int fmi2EnterInitializationMode(void *);
int fmi2ExitInitializationMode(void *);
int fmi2Terminate(void *);
int fmi2Reset(void *);
int fmi2GetReal(void *, const unsigned int *, size_t, double *);
int fmi2SetReal(void *, const unsigned int *, size_t, const double *);
int fmi2GetInteger(void *, const unsigned int *, size_t, int *);
int fmi2GetFMUstate(void *, void **);
int fmi2SetFMUstate(void *, void *);
int fmi2FreeFMUstate(void *, void **);
int fmi2SerializedFMUstateSize(void *, void *, size_t *);
int fmi2SerializeFMUstate(void *, void *, char *, size_t);
int fmi2DeSerializeFMUstate(void *, const char *, size_t, void **);
int fmi2DoStep(void *, double, double, int);
int fmi2GetRealStatus(void *, int, double *);

static char said[400];

static void say(void *environment, const char *name, int status, const char *category, const char *format, ...)
{
    (void)environment;
    (void)name;
    (void)status;
    (void)category;
    (void)format;
    (void)strcpy(said, "something");
}

#define CHECK(condition)                                        \
    do {                                                        \
        if (!(condition)) {                                     \
            printf("line %d: %s\n", __LINE__, #condition);      \
            exit(1);                                            \
        }                                                       \
    } while (0)

static unsigned int references[64];

/* The golden vectors of a plant that depends on time start at 0. */
#define START (TIMED ? 0.0 : 2.0)

static void initialize_at(void *c, double start)
{
    CHECK(fmi2SetupExperiment(c, 0, 0.0, start, 0, 0.0) == 0);
    CHECK(fmi2EnterInitializationMode(c) == 0);
    CHECK(fmi2ExitInitializationMode(c) == 0);
}

static void initialize(void *c)
{
    initialize_at(c, START);
}

/* Sets u, or r with feedback, and y, steps, gets xhat; returns whether it is the expected one. With feedback u is to be
 * the expected one as soon as r is set. */
static int step(void *c, int k)
{
    double xhat[N];
    double applied[M + 1];
    if (M > 0) {
        CHECK(fmi2SetReal(c, &references[FED ? (1 + M + P + N + P + N) : 1], (size_t)M, golden_u[k]) == 0);
    }
    if (FED) {
        CHECK(fmi2GetReal(c, &references[1], (size_t)M, applied) == 0);
        CHECK(memcmp(applied, golden_applied[k], sizeof(double) * (size_t)M) == 0);
        CHECK(fmi2SetReal(c, &references[1], (size_t)M, applied) == 3);
    }
    CHECK(fmi2SetReal(c, &references[1 + M], (size_t)P, golden_y[k]) == 0);
    CHECK(fmi2DoStep(c, START + (double)k * PERIOD, PERIOD, 1) == 0);
    CHECK(fmi2GetReal(c, &references[1 + M + P], (size_t)N, xhat) == 0);
    return memcmp(xhat, golden_xhat[k], sizeof xhat) == 0;
}

int main(void)
{
    callbacks functions = { say, calloc, free, NULL, NULL };
    void *c;
    void *state = NULL;
    void *copy = NULL;
    char *bytes;
    size_t size = 0;
    double time = 0.0;
    double bad = 0.0;
    double innovation = 1.0;
    int integer;
    int k;
    int good = 0;

    for (k = 0; k < 64; ++k) {
        references[k] = (unsigned int)k;
    }
    CHECK(strcmp(fmi2GetVersion(), "2.0") == 0);
    CHECK(fmi2Instantiate("a", 1, "{0}", "", &functions, 0, 0) == NULL);
    CHECK(fmi2Instantiate("a", 0, TOKEN, "", &functions, 0, 0) == NULL);
    c = fmi2Instantiate("a", 1, TOKEN, "", &functions, 0, 0);
    CHECK(c != NULL);
    CHECK(fmi2DoStep(c, 0.0, PERIOD, 1) == 3);
    initialize(c);
    for (k = 0; k < STEPS; ++k) {
        good += step(c, k);
        if (k == 20) {
            CHECK(fmi2GetFMUstate(c, &state) == 0);
        }
    }
    CHECK((fmi2GetRealStatus(c, 2, &time) == 0) && (time > START + 63.5 * PERIOD) && (time < START + 64.5 * PERIOD));

    /* Back to the state after step 20, by way of bytes. */
    CHECK(fmi2SerializedFMUstateSize(c, state, &size) == 0);
    bytes = malloc(size);
    CHECK((bytes != NULL) && (fmi2SerializeFMUstate(c, state, bytes, size) == 0));
    CHECK(fmi2FreeFMUstate(c, &state) == 0);
    CHECK(fmi2DeSerializeFMUstate(c, bytes, size, &copy) == 0);
    CHECK(fmi2SetFMUstate(c, copy) == 0);
    CHECK(fmi2FreeFMUstate(c, &copy) == 0);
    CHECK(fmi2DeSerializeFMUstate(c, bytes, size - 1, &copy) == 3);
    bytes[1] = (char)(bytes[1] + 1);
    CHECK(fmi2DeSerializeFMUstate(c, bytes, size, &copy) == 3);
    free(bytes);
    CHECK(step(c, 21) && step(c, 22));

    /* What is refused. */
    said[0] = '\0';
    CHECK(fmi2DoStep(c, 0.0, 0.7 * PERIOD, 1) == 3);
    CHECK(said[0] != '\0');
    CHECK(fmi2DoStep(c, 0.0, 0.0, 1) == 3);
    CHECK(fmi2DoStep(c, 0.0, -PERIOD, 1) == 3);
    CHECK(fmi2SetReal(c, &references[1 + M + P], 1, &bad) == 3);
    CHECK(fmi2SetReal(c, &references[1 + M + P + N + P], 1, &bad) == 3);
    CHECK(fmi2GetReal(c, &references[63], 1, &bad) == 3);
    CHECK(fmi2GetInteger(c, references, 1, &integer) == 3);
    CHECK(step(c, 23));

    /* Two periods in one step: the inputs are held. */
    CHECK(fmi2DoStep(c, 0.0, 2.0 * PERIOD, 1) == 0);

    /* A linear observer passes over a measurement that is not finite; such an input is a warning, until the reset. A
     * nonlinear plant may limit its effect. */
    bad = 1e308 * 10.0;
    CHECK(fmi2SetReal(c, &references[1 + M], 1, &bad) == 0);
    k = fmi2DoStep(c, 0.0, PERIOD, 1);
    CHECK((k == 0) || (!LINEAR && (k == 1)));
    CHECK((fmi2GetReal(c, &references[1 + M + P + N], 1, &innovation) == 0) && (innovation == 0.0));
    if (M > 0) {
        CHECK(fmi2SetReal(c, &references[FED ? (1 + M + P + N + P + N) : 1], 1, &bad) == 0);
        k = fmi2DoStep(c, 0.0, PERIOD, 1);
        CHECK((k == 1) || (!LINEAR && (k == 0)));
    }
    CHECK(fmi2Reset(c) == 0);
    initialize(c);
    CHECK(step(c, 0) && step(c, 1));
    /* A late time is rounded by more than a part of a short period. */
    CHECK(fmi2DoStep(c, 1e9 * PERIOD, (1e9 * PERIOD + PERIOD) - 1e9 * PERIOD, 1) == 0);
    CHECK(fmi2DoStep(c, 1e9 * PERIOD, 1.001 * PERIOD, 1) == 3);

    /* A copy of a plant that depends on time, whose state is its estimate, goes on from that of a later sample. Its samples are at multiples of
     * the period; other plants start at any time. */
    CHECK(fmi2Reset(c) == 0);
    said[0] = '\0';
    CHECK(fmi2SetupExperiment(c, 0, 0.0, 5.5 * PERIOD, 0, 0.0) == (TIMED ? 3 : 0));
    CHECK((said[0] != '\0') == TIMED);
    CHECK(fmi2Reset(c) == 0);
    CHECK(fmi2SetupExperiment(c, 0, 0.0, -PERIOD, 0, 0.0) == (TIMED ? 3 : 0));
    CHECK(fmi2Reset(c) == 0);
    if (TIMED && COPY) {
        CHECK(fmi2SetReal(c, &references[1 + M + P + N + P], (size_t)N, golden_xhat[4]) == 0);
        initialize_at(c, 5.0 * PERIOD);
        for (k = 5; k < 12; ++k) {
            CHECK(step(c, k));
        }
        CHECK(fmi2Reset(c) == 0);
    }
    initialize(c);
    CHECK(fmi2Terminate(c) == 0);
    CHECK(fmi2DoStep(c, 0.0, PERIOD, 1) == 3);
    fmi2FreeInstance(c);
    printf("%d of %d steps agree\n", good, STEPS);
    return (good == STEPS) ? 0 : 1;
}
