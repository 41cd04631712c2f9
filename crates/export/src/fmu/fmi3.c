/* Co-simulation by FMI 3.0.
 * The functions are those of the standard; what they do is in instance.h.
 * This file belongs to whoever generated it. */
#include "instance.h"

#include <stdbool.h>

#ifdef FMI3_FUNCTION_PREFIX
#define F(name) JOINED(FMI3_FUNCTION_PREFIX, name)
#else
#define F(name) name
#endif

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*logger)(void *environment, fmi3Status status, const char *category, const char *message);
typedef void (*update)(void *environment, double time, bool set_requested, bool get_allowed, bool step_finished,
                       bool can_return, bool *return_requested, double *return_time);

typedef struct {
    model m;
    logger log;
    void *environment;
} instance;

static fmi3Status say(const instance *i, fmi3Status status, const char *message)
{
    const char *category = (status == fmi3Warning) ? "logStatusWarning" : "logStatusError";
    if (i->log != NULL) {
        i->log(i->environment, status, category, message);
    }
    return status;
}

static fmi3Status fail(const void *c, const char *message)
{
    return say((const instance *)c, fmi3Error, message);
}

FMI_EXPORT const char *F(fmi3GetVersion)(void)
{
    return "3.0";
}

FMI_EXPORT fmi3Status F(fmi3SetDebugLogging)(void *c, bool on, size_t count, const char *const categories[])
{
    (void)c;
    (void)on;
    (void)count;
    (void)categories;
    return fmi3OK;
}

FMI_EXPORT void *F(fmi3InstantiateModelExchange)(const char *name, const char *token, const char *resources,
                                                 bool visible, bool logging, void *environment, logger log)
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    if (log != NULL) {
        log(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation");
    }
    return NULL;
}

FMI_EXPORT void *F(fmi3InstantiateCoSimulation)(const char *name, const char *token, const char *resources,
                                                bool visible, bool logging, bool event_mode, bool early_return,
                                                const uint32_t required[], size_t required_count, void *environment,
                                                logger log, update intermediate)
{
    instance *i = (instance *)calloc((size_t)1, sizeof *i);
    (void)name;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)early_return;
    (void)required;
    (void)required_count;
    (void)intermediate;
    if (i == NULL) {
        return NULL;
    }
    i->log = log;
    i->environment = environment;
    if (event_mode) {
        (void)fail(i, "this FMU has no event mode");
    } else if ((token == NULL) || (strcmp(token, MODEL_TOKEN) != 0)) {
        (void)fail(i, "the instantiation token is that of another FMU");
    } else {
        model_begin(&i->m);
        return i;
    }
    free(i);
    return NULL;
}

FMI_EXPORT void *F(fmi3InstantiateScheduledExecution)(const char *name, const char *token, const char *resources,
                                                      bool visible, bool logging, void *environment, logger log,
                                                      void (*clock)(void *), void (*lock)(void), void (*unlock)(void))
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)clock;
    (void)lock;
    (void)unlock;
    if (log != NULL) {
        log(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation");
    }
    return NULL;
}

FMI_EXPORT void F(fmi3FreeInstance)(void *c)
{
    free(c);
}

FMI_EXPORT fmi3Status F(fmi3EnterInitializationMode)(void *c, bool has_tolerance, double tolerance, double start,
                                                     bool has_stop, double stop)
{
    instance *i = (instance *)c;
    char message[MESSAGE];
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    if (i->m.now != INSTANTIATED) {
        return fail(c, "fmi3EnterInitializationMode: the FMU is initialized already");
    }
    if (model_start(&i->m, start, message) != 0) {
        return fail(c, message);
    }
    i->m.now = INITIALIZING;
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3ExitInitializationMode)(void *c)
{
    instance *i = (instance *)c;
    if (i->m.now != INITIALIZING) {
        return fail(c, "fmi3ExitInitializationMode comes after fmi3EnterInitializationMode");
    }
    model_prepare(&i->m);
    i->m.now = STEPPING;
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3Terminate)(void *c)
{
    instance *i = (instance *)c;
    if (i->m.now != STEPPING) {
        return fail(c, "fmi3Terminate comes after the initialization, once");
    }
    i->m.now = TERMINATED;
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3Reset)(void *c)
{
    model_begin(&((instance *)c)->m);
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3GetFloat64)(void *c, const uint32_t references[], size_t count, double values[],
                                        size_t value_count)
{
    const instance *i = (const instance *)c;
    size_t k;
    if (value_count != count) {
        return fail(c, "fmi3GetFloat64: all variables are scalars");
    }
    for (k = 0; k < count; ++k) {
        if (references[k] >= (uint32_t)VARIABLES) {
            return fail(c, "fmi3GetFloat64: there is no variable of this value reference");
        }
        values[k] = i->m.values[references[k]];
    }
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3SetFloat64)(void *c, const uint32_t references[], size_t count, const double values[],
                                        size_t value_count)
{
    instance *i = (instance *)c;
    size_t k;
    if (value_count != count) {
        return fail(c, "fmi3SetFloat64: all variables are scalars");
    }
    for (k = 0; k < count; ++k) {
        const char *why = model_set(&i->m, references[k], values[k]);
        if (why != NULL) {
            return fail(c, why);
        }
    }
    return fmi3OK;
}

/* All variables are of the type Float64. */
#define NONE(name, type)                                                                                              \
    FMI_EXPORT fmi3Status F(name)(void *c, const uint32_t references[], size_t count, type values[], size_t number)  \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        (void)number;                                                                                                  \
        return (count == (size_t)0) ? fmi3OK : fail(c, #name ": all variables are of the type Float64");              \
    }
NONE(fmi3GetFloat32, float)
NONE(fmi3GetInt8, int8_t)
NONE(fmi3GetUInt8, uint8_t)
NONE(fmi3GetInt16, int16_t)
NONE(fmi3GetUInt16, uint16_t)
NONE(fmi3GetInt32, int32_t)
NONE(fmi3GetUInt32, uint32_t)
NONE(fmi3GetInt64, int64_t)
NONE(fmi3GetUInt64, uint64_t)
NONE(fmi3GetBoolean, bool)
NONE(fmi3GetString, const char *)
NONE(fmi3SetFloat32, const float)
NONE(fmi3SetInt8, const int8_t)
NONE(fmi3SetUInt8, const uint8_t)
NONE(fmi3SetInt16, const int16_t)
NONE(fmi3SetUInt16, const uint16_t)
NONE(fmi3SetInt32, const int32_t)
NONE(fmi3SetUInt32, const uint32_t)
NONE(fmi3SetInt64, const int64_t)
NONE(fmi3SetUInt64, const uint64_t)
NONE(fmi3SetBoolean, const bool)
NONE(fmi3SetString, const char *const)

#define NO_BYTES(name, size_type, type)                                                                               \
    FMI_EXPORT fmi3Status F(name)(void *c, const uint32_t references[], size_t count, size_type sizes[],             \
                                  type values[], size_t number)                                                       \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)sizes;                                                                                                   \
        (void)values;                                                                                                  \
        (void)number;                                                                                                  \
        return (count == (size_t)0) ? fmi3OK : fail(c, #name ": all variables are of the type Float64");              \
    }
NO_BYTES(fmi3GetBinary, size_t, const uint8_t *)
NO_BYTES(fmi3SetBinary, const size_t, const uint8_t *const)

#define NO_CLOCK(name, type)                                                                                          \
    FMI_EXPORT fmi3Status F(name)(void *c, const uint32_t references[], size_t count, type values[])                  \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        return (count == (size_t)0) ? fmi3OK : fail(c, #name ": there are no clocks");                                \
    }
NO_CLOCK(fmi3GetClock, bool)
NO_CLOCK(fmi3SetClock, const bool)
NO_CLOCK(fmi3GetShiftDecimal, double)
NO_CLOCK(fmi3SetIntervalDecimal, const double)
NO_CLOCK(fmi3SetShiftDecimal, const double)

#define NO_CLOCKS(name, first, second)                                                                                \
    FMI_EXPORT fmi3Status F(name)(void *c, const uint32_t references[], size_t count, first one[], second two[])      \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)one;                                                                                                     \
        (void)two;                                                                                                     \
        return (count == (size_t)0) ? fmi3OK : fail(c, #name ": there are no clocks");                                \
    }
NO_CLOCKS(fmi3GetIntervalDecimal, double, int)
NO_CLOCKS(fmi3GetShiftFraction, uint64_t, uint64_t)
NO_CLOCKS(fmi3SetIntervalFraction, const uint64_t, const uint64_t)
NO_CLOCKS(fmi3SetShiftFraction, const uint64_t, const uint64_t)

FMI_EXPORT fmi3Status F(fmi3GetIntervalFraction)(void *c, const uint32_t references[], size_t count,
                                                 uint64_t counters[], uint64_t resolutions[], int qualifiers[])
{
    (void)references;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return (count == (size_t)0) ? fmi3OK : fail(c, "fmi3GetIntervalFraction: there are no clocks");
}

FMI_EXPORT fmi3Status F(fmi3GetFMUState)(void *c, void **state)
{
    instance *i = (instance *)c;
    if (*state != NULL) {
        (void)memcpy(*state, &i->m, sizeof i->m);
        return fmi3OK;
    }
    *state = model_copy(&i->m);
    return (*state != NULL) ? fmi3OK : fail(c, "fmi3GetFMUState: no memory");
}

FMI_EXPORT fmi3Status F(fmi3SetFMUState)(void *c, void *state)
{
    instance *i = (instance *)c;
    if (state == NULL) {
        return fail(c, "fmi3SetFMUState: there is no state");
    }
    (void)memcpy(&i->m, state, sizeof i->m);
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3FreeFMUState)(void *c, void **state)
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3SerializedFMUStateSize)(void *c, void *state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(serialized);
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3SerializeFMUState)(void *c, void *state, uint8_t bytes[], size_t size)
{
    if ((state == NULL) || (size < sizeof(serialized))) {
        return fail(c, "fmi3SerializeFMUState: no state, or too few bytes");
    }
    model_serialize((const model *)state, bytes);
    return fmi3OK;
}

FMI_EXPORT fmi3Status F(fmi3DeserializeFMUState)(void *c, const uint8_t bytes[], size_t size, void **state)
{
    *state = model_deserialize(bytes, size);
    return (*state != NULL) ? fmi3OK : fail(c, "fmi3DeserializeFMUState: these bytes are not a state of this FMU");
}

FMI_EXPORT fmi3Status F(fmi3DoStep)(void *c, double from, double size, bool no_set_state, bool *event, bool *terminate,
                                    bool *early, double *last)
{
    instance *i = (instance *)c;
    char message[MESSAGE];
    (void)no_set_state;
    *event = false;
    *terminate = false;
    *early = false;
    *last = i->m.values[TIME];
    if (i->m.now != STEPPING) {
        return fail(c, "fmi3DoStep comes after the initialization and before fmi3Terminate");
    }
    if (model_do_step(&i->m, from, size, message) != 0) {
        return fail(c, message);
    }
    *last = i->m.values[TIME];
    return model_is_finite(&i->m) ? fmi3OK : say(i, fmi3Warning, NOT_FINITE);
}

FMI_EXPORT fmi3Status F(fmi3UpdateDiscreteStates)(void *c, bool *again, bool *terminate, bool *nominals, bool *values,
                                                  bool *has_next, double *next)
{
    *again = false;
    *terminate = false;
    *nominals = false;
    *values = false;
    *has_next = false;
    *next = 0.0;
    return fail(c, "fmi3UpdateDiscreteStates: this FMU has no event mode");
}

/* What an FMU for co-simulation without events, clocks and derivatives does not have. */
#define NO_MODE(name)                                                                                                 \
    FMI_EXPORT fmi3Status F(name)(void *c)                                                                            \
    {                                                                                                                  \
        return fail(c, #name ": this FMU is for co-simulation, without event mode");                                 \
    }
NO_MODE(fmi3EnterEventMode)
NO_MODE(fmi3EnterStepMode)
NO_MODE(fmi3EnterConfigurationMode)
NO_MODE(fmi3ExitConfigurationMode)
NO_MODE(fmi3EvaluateDiscreteStates)
NO_MODE(fmi3EnterContinuousTimeMode)

#define NO_COUNT(name)                                                                                                \
    FMI_EXPORT fmi3Status F(name)(void *c, size_t *count)                                                             \
    {                                                                                                                  \
        *count = 0;                                                                                                    \
        return fail(c, #name ": this FMU is for co-simulation");                                                      \
    }
NO_COUNT(fmi3GetNumberOfEventIndicators)
NO_COUNT(fmi3GetNumberOfContinuousStates)

#define NO_VECTOR(name, type)                                                                                         \
    FMI_EXPORT fmi3Status F(name)(void *c, type values[], size_t count)                                               \
    {                                                                                                                  \
        (void)values;                                                                                                  \
        (void)count;                                                                                                   \
        return fail(c, #name ": this FMU is for co-simulation");                                                      \
    }
NO_VECTOR(fmi3SetContinuousStates, const double)
NO_VECTOR(fmi3GetContinuousStateDerivatives, double)
NO_VECTOR(fmi3GetEventIndicators, double)
NO_VECTOR(fmi3GetContinuousStates, double)
NO_VECTOR(fmi3GetNominalsOfContinuousStates, double)

#define NO_DERIVATIVE(name)                                                                                           \
    FMI_EXPORT fmi3Status F(name)(void *c, const uint32_t unknowns[], size_t unknown_count, const uint32_t knowns[], \
                                  size_t known_count, const double seed[], size_t seed_count, double result[],        \
                                  size_t result_count)                                                                \
    {                                                                                                                  \
        (void)unknowns;                                                                                                \
        (void)unknown_count;                                                                                           \
        (void)knowns;                                                                                                  \
        (void)known_count;                                                                                             \
        (void)seed;                                                                                                    \
        (void)seed_count;                                                                                              \
        (void)result;                                                                                                  \
        (void)result_count;                                                                                            \
        return fail(c, #name " is not provided");                                                                     \
    }
NO_DERIVATIVE(fmi3GetDirectionalDerivative)
NO_DERIVATIVE(fmi3GetAdjointDerivative)

FMI_EXPORT fmi3Status F(fmi3GetNumberOfVariableDependencies)(void *c, uint32_t reference, size_t *count)
{
    (void)reference;
    *count = 0;
    return fail(c, "fmi3GetNumberOfVariableDependencies is not provided");
}

FMI_EXPORT fmi3Status F(fmi3GetVariableDependencies)(void *c, uint32_t dependent, size_t elements[],
                                                     uint32_t independents[], size_t independent_elements[],
                                                     int kinds[], size_t count)
{
    (void)dependent;
    (void)elements;
    (void)independents;
    (void)independent_elements;
    (void)kinds;
    (void)count;
    return fail(c, "fmi3GetVariableDependencies is not provided");
}

FMI_EXPORT fmi3Status F(fmi3GetOutputDerivatives)(void *c, const uint32_t references[], size_t count,
                                                  const int32_t orders[], double values[], size_t value_count)
{
    (void)references;
    (void)orders;
    (void)values;
    (void)value_count;
    return (count == (size_t)0) ? fmi3OK : fail(c, "fmi3GetOutputDerivatives: outputs change by steps");
}

FMI_EXPORT fmi3Status F(fmi3SetTime)(void *c, double time)
{
    (void)time;
    return fail(c, "fmi3SetTime: this FMU is for co-simulation");
}

FMI_EXPORT fmi3Status F(fmi3CompletedIntegratorStep)(void *c, bool no_set_state, bool *event, bool *terminate)
{
    (void)no_set_state;
    *event = false;
    *terminate = false;
    return fail(c, "fmi3CompletedIntegratorStep: this FMU is for co-simulation");
}

FMI_EXPORT fmi3Status F(fmi3ActivateModelPartition)(void *c, uint32_t clock, double time)
{
    (void)clock;
    (void)time;
    return fail(c, "fmi3ActivateModelPartition: this FMU is for co-simulation");
}
