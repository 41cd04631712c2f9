/* Imports an FMU 3.0 that is linked to it. Exit code 0 if all is as it should be. */
#include "vectors.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *fmi3GetVersion(void);
typedef void (*logger)(void *, int, const char *, const char *);
void *fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *,
                                  size_t, void *, logger, void *);
void *fmi3InstantiateModelExchange(const char *, const char *, const char *, bool, bool, void *, logger);
void fmi3FreeInstance(void *);
int fmi3EnterInitializationMode(void *, bool, double, double, bool, double);
int fmi3ExitInitializationMode(void *);
int fmi3Terminate(void *);
int fmi3Reset(void *);
int fmi3GetFloat64(void *, const uint32_t *, size_t, double *, size_t);
int fmi3SetFloat64(void *, const uint32_t *, size_t, const double *, size_t);
int fmi3GetInt32(void *, const uint32_t *, size_t, int32_t *, size_t);
int fmi3GetFMUState(void *, void **);
int fmi3SetFMUState(void *, void *);
int fmi3FreeFMUState(void *, void **);
int fmi3SerializedFMUStateSize(void *, void *, size_t *);
int fmi3SerializeFMUState(void *, void *, uint8_t *, size_t);
int fmi3DeserializeFMUState(void *, const uint8_t *, size_t, void **);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);

static char said[400];

static double reached;

static void say(void *environment, int status, const char *category, const char *message)
{
    (void)environment;
    (void)status;
    (void)category;
    (void)strncpy(said, message, sizeof said - 1);
}

static int do_step(void *c, double from, double size)
{
    bool event = true;
    bool terminate = true;
    bool early = true;
    const int status = fmi3DoStep(c, from, size, true, &event, &terminate, &early, &reached);
    return (event || terminate || early) ? 9 : status;
}

#define CHECK(condition)                                        \
    do {                                                        \
        if (!(condition)) {                                     \
            printf("line %d: %s\n", __LINE__, #condition);      \
            exit(1);                                            \
        }                                                       \
    } while (0)

static uint32_t references[64];

/* The golden vectors of a plant that depends on time start at 0. */
#define START (TIMED ? 0.0 : 2.0)

static void initialize_at(void *c, double start)
{
    CHECK(fmi3EnterInitializationMode(c, false, 0.0, start, false, 0.0) == 0);
    CHECK(fmi3ExitInitializationMode(c) == 0);
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
        const uint32_t *known = &references[FED ? (1 + M + P + N + P + N) : 1];
        CHECK(fmi3SetFloat64(c, known, (size_t)M, golden_u[k], (size_t)M) == 0);
    }
    if (FED) {
        CHECK(fmi3GetFloat64(c, &references[1], (size_t)M, applied, (size_t)M) == 0);
        CHECK(memcmp(applied, golden_applied[k], sizeof(double) * (size_t)M) == 0);
        CHECK(fmi3SetFloat64(c, &references[1], (size_t)M, applied, (size_t)M) == 3);
    }
    CHECK(fmi3SetFloat64(c, &references[1 + M], (size_t)P, golden_y[k], (size_t)P) == 0);
    CHECK(do_step(c, START + (double)k * PERIOD, PERIOD) == 0);
    CHECK(fmi3GetFloat64(c, &references[1 + M + P], (size_t)N, xhat, (size_t)N) == 0);
    return memcmp(xhat, golden_xhat[k], sizeof xhat) == 0;
}

int main(void)
{
    void *c;
    void *state = NULL;
    void *copy = NULL;
    uint8_t *bytes;
    size_t size = 0;
    double bad = 0.0;
    double innovation = 1.0;
    int32_t integer;
    int k;
    int good = 0;

    for (k = 0; k < 64; ++k) {
        references[k] = (uint32_t)k;
    }
    CHECK(strcmp(fmi3GetVersion(), "3.0") == 0);
    CHECK(fmi3InstantiateCoSimulation("a", "{0}", "", false, false, false, false, NULL, 0, NULL, say, NULL) == NULL);
    CHECK(fmi3InstantiateModelExchange("a", TOKEN, "", false, false, NULL, say) == NULL);
    c = fmi3InstantiateCoSimulation("a", TOKEN, "", false, false, false, false, NULL, 0, NULL, say, NULL);
    CHECK(c != NULL);
    CHECK(do_step(c, 0.0, PERIOD) == 3);
    initialize(c);
    for (k = 0; k < STEPS; ++k) {
        good += step(c, k);
        if (k == 20) {
            CHECK(fmi3GetFMUState(c, &state) == 0);
        }
    }
    CHECK((reached > START + 63.5 * PERIOD) && (reached < START + 64.5 * PERIOD));

    /* Back to the state after step 20, by way of bytes. */
    CHECK(fmi3SerializedFMUStateSize(c, state, &size) == 0);
    bytes = malloc(size);
    CHECK((bytes != NULL) && (fmi3SerializeFMUState(c, state, bytes, size) == 0));
    CHECK(fmi3FreeFMUState(c, &state) == 0);
    CHECK(fmi3DeserializeFMUState(c, bytes, size, &copy) == 0);
    CHECK(fmi3SetFMUState(c, copy) == 0);
    CHECK(fmi3FreeFMUState(c, &copy) == 0);
    CHECK(fmi3DeserializeFMUState(c, bytes, size - 1, &copy) == 3);
    bytes[1] = (uint8_t)(bytes[1] + 1u);
    CHECK(fmi3DeserializeFMUState(c, bytes, size, &copy) == 3);
    free(bytes);
    CHECK(step(c, 21) && step(c, 22));

    /* What is refused. */
    said[0] = '\0';
    CHECK(do_step(c, 0.0, 0.7 * PERIOD) == 3);
    CHECK(strstr(said, "is not a multiple of the sampling period") != NULL);
    CHECK(do_step(c, 0.0, 0.0) == 3);
    CHECK(do_step(c, 0.0, -PERIOD) == 3);
    CHECK(fmi3SetFloat64(c, &references[1 + M + P], 1, &bad, 1) == 3);
    CHECK(fmi3SetFloat64(c, &references[1 + M + P + N + P], 1, &bad, 1) == 3);
    CHECK(fmi3GetFloat64(c, &references[63], 1, &bad, 1) == 3);
    CHECK(fmi3GetInt32(c, references, 1, &integer, 1) == 3);
    CHECK(step(c, 23));

    /* Two periods in one step: the inputs are held. */
    CHECK(do_step(c, 0.0, 2.0 * PERIOD) == 0);

    /* A linear observer passes over a measurement that is not finite; such an input is a warning, until the reset. A
     * nonlinear plant may limit its effect. */
    bad = 1e308 * 10.0;
    CHECK(fmi3SetFloat64(c, &references[1 + M], 1, &bad, 1) == 0);
    k = do_step(c, 0.0, PERIOD);
    CHECK((k == 0) || (!LINEAR && (k == 1)));
    CHECK((fmi3GetFloat64(c, &references[1 + M + P + N], 1, &innovation, 1) == 0) && (innovation == 0.0));
    if (M > 0) {
        CHECK(fmi3SetFloat64(c, &references[FED ? (1 + M + P + N + P + N) : 1], 1, &bad, 1) == 0);
        k = do_step(c, 0.0, PERIOD);
        CHECK((k == 1) || (!LINEAR && (k == 0)));
    }
    CHECK(fmi3Reset(c) == 0);
    initialize(c);
    CHECK(step(c, 0) && step(c, 1));
    /* A late time is rounded by more than a part of a short period. */
    CHECK(do_step(c, 1e9 * PERIOD, (1e9 * PERIOD + PERIOD) - 1e9 * PERIOD) == 0);
    CHECK(do_step(c, 1e9 * PERIOD, 1.001 * PERIOD) == 3);

    /* A copy of a plant that depends on time, whose state is its estimate, goes on from that of a later sample. Its samples are at multiples of
     * the period; other plants start at any time. */
    CHECK(fmi3Reset(c) == 0);
    said[0] = '\0';
    CHECK(fmi3EnterInitializationMode(c, false, 0.0, 5.5 * PERIOD, false, 0.0) == (TIMED ? 3 : 0));
    CHECK((said[0] != '\0') == TIMED);
    CHECK(fmi3Reset(c) == 0);
    CHECK(fmi3EnterInitializationMode(c, false, 0.0, -PERIOD, false, 0.0) == (TIMED ? 3 : 0));
    CHECK(fmi3Reset(c) == 0);
    if (TIMED && COPY) {
        CHECK(fmi3SetFloat64(c, &references[1 + M + P + N + P], (size_t)N, golden_xhat[4], (size_t)N) == 0);
        initialize_at(c, 5.0 * PERIOD);
        for (k = 5; k < 12; ++k) {
            CHECK(step(c, k));
        }
        CHECK(fmi3Reset(c) == 0);
    }
    initialize(c);
    CHECK(fmi3Terminate(c) == 0);
    CHECK(do_step(c, 0.0, PERIOD) == 3);
    fmi3FreeInstance(c);
    printf("%d of %d steps agree\n", good, STEPS);
    return (good == STEPS) ? 0 : 1;
}
