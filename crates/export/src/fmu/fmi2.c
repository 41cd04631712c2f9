/* Co-simulation by FMI 2.0.
 * The functions are those of the standard; what they do is in instance.h.
 * This file belongs to whoever generated it. */
#include "instance.h"

#ifdef FMI2_FUNCTION_PREFIX
#define F(name) JOINED(FMI2_FUNCTION_PREFIX, name)
#else
#define F(name) name
#endif

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef void (*logger)(void *environment, const char *instance, fmi2Status status, const char *category,
                       const char *message, ...);
typedef struct {
    logger log;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *block);
    void (*finished)(void *environment, fmi2Status status);
    void *environment;
} callbacks;

typedef struct {
    model m;
    char name[NAME];
    logger log;
    void *environment;
} instance;

static fmi2Status say(const instance *i, fmi2Status status, const char *message)
{
    const char *category = (status == fmi2Warning) ? "logStatusWarning" : "logStatusError";
    if (i->log != NULL) {
        i->log(i->environment, i->name, status, category, "%s", message);
    }
    return status;
}

static fmi2Status fail(const void *c, const char *message)
{
    return say((const instance *)c, fmi2Error, message);
}

FMI_EXPORT const char *F(fmi2GetTypesPlatform)(void)
{
    return "default";
}

FMI_EXPORT const char *F(fmi2GetVersion)(void)
{
    return "2.0";
}

FMI_EXPORT fmi2Status F(fmi2SetDebugLogging)(void *c, int on, size_t count, const char *const categories[])
{
    (void)c;
    (void)on;
    (void)count;
    (void)categories;
    return fmi2OK;
}

FMI_EXPORT void *F(fmi2Instantiate)(const char *name, fmi2Type type, const char *guid, const char *resources,
                                    const callbacks *functions, int visible, int logging)
{
    instance *i = (instance *)calloc((size_t)1, sizeof *i);
    (void)resources;
    (void)visible;
    (void)logging;
    if (i == NULL) {
        return NULL;
    }
    if (functions != NULL) {
        i->log = functions->log;
        i->environment = functions->environment;
    }
    (void)snprintf(i->name, sizeof i->name, "%s", (name != NULL) ? name : "");
    if (type != fmi2CoSimulation) {
        (void)fail(i, "this FMU is for co-simulation");
    } else if ((guid == NULL) || (strcmp(guid, MODEL_TOKEN) != 0)) {
        (void)fail(i, "the GUID is that of another FMU");
    } else {
        model_begin(&i->m);
        return i;
    }
    free(i);
    return NULL;
}

FMI_EXPORT void F(fmi2FreeInstance)(void *c)
{
    free(c);
}

FMI_EXPORT fmi2Status F(fmi2SetupExperiment)(void *c, int has_tolerance, double tolerance, double start, int has_stop,
                                             double stop)
{
    instance *i = (instance *)c;
    char message[MESSAGE];
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    if (i->m.now != INSTANTIATED) {
        return fail(c, "fmi2SetupExperiment comes before fmi2EnterInitializationMode");
    }
    return (model_start(&i->m, start, message) == 0) ? fmi2OK : fail(c, message);
}

FMI_EXPORT fmi2Status F(fmi2EnterInitializationMode)(void *c)
{
    instance *i = (instance *)c;
    if (i->m.now != INSTANTIATED) {
        return fail(c, "fmi2EnterInitializationMode: the FMU is initialized already");
    }
    i->m.now = INITIALIZING;
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2ExitInitializationMode)(void *c)
{
    instance *i = (instance *)c;
    if (i->m.now != INITIALIZING) {
        return fail(c, "fmi2ExitInitializationMode comes after fmi2EnterInitializationMode");
    }
    model_prepare(&i->m);
    i->m.now = STEPPING;
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2Terminate)(void *c)
{
    instance *i = (instance *)c;
    if (i->m.now != STEPPING) {
        return fail(c, "fmi2Terminate comes after the initialization, once");
    }
    i->m.now = TERMINATED;
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2Reset)(void *c)
{
    model_begin(&((instance *)c)->m);
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2GetReal)(void *c, const unsigned int references[], size_t count, double values[])
{
    const instance *i = (const instance *)c;
    size_t k;
    for (k = 0; k < count; ++k) {
        if (references[k] >= (unsigned int)VARIABLES) {
            return fail(c, "fmi2GetReal: there is no variable of this value reference");
        }
        values[k] = i->m.values[references[k]];
    }
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2SetReal)(void *c, const unsigned int references[], size_t count, const double values[])
{
    instance *i = (instance *)c;
    size_t k;
    for (k = 0; k < count; ++k) {
        const char *why = model_set(&i->m, (uint32_t)references[k], values[k]);
        if (why != NULL) {
            return fail(c, why);
        }
    }
    return fmi2OK;
}

/* All variables are of the type Real. */
#define NONE(name, type)                                                                                              \
    FMI_EXPORT fmi2Status F(name)(void *c, const unsigned int references[], size_t count, type values[])              \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        return (count == (size_t)0) ? fmi2OK : fail(c, #name ": all variables are of the type Real");                 \
    }
NONE(fmi2GetInteger, int)
NONE(fmi2GetBoolean, int)
NONE(fmi2GetString, const char *)
NONE(fmi2SetInteger, const int)
NONE(fmi2SetBoolean, const int)
NONE(fmi2SetString, const char *const)

FMI_EXPORT fmi2Status F(fmi2GetFMUstate)(void *c, void **state)
{
    instance *i = (instance *)c;
    if (*state != NULL) {
        (void)memcpy(*state, &i->m, sizeof i->m);
        return fmi2OK;
    }
    *state = model_copy(&i->m);
    return (*state != NULL) ? fmi2OK : fail(c, "fmi2GetFMUstate: no memory");
}

FMI_EXPORT fmi2Status F(fmi2SetFMUstate)(void *c, void *state)
{
    instance *i = (instance *)c;
    if (state == NULL) {
        return fail(c, "fmi2SetFMUstate: there is no state");
    }
    (void)memcpy(&i->m, state, sizeof i->m);
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2FreeFMUstate)(void *c, void **state)
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2SerializedFMUstateSize)(void *c, void *state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(serialized);
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2SerializeFMUstate)(void *c, void *state, char bytes[], size_t size)
{
    if ((state == NULL) || (size < sizeof(serialized))) {
        return fail(c, "fmi2SerializeFMUstate: no state, or too few bytes");
    }
    model_serialize((const model *)state, (unsigned char *)bytes);
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2DeSerializeFMUstate)(void *c, const char bytes[], size_t size, void **state)
{
    *state = model_deserialize((const unsigned char *)bytes, size);
    return (*state != NULL) ? fmi2OK : fail(c, "fmi2DeSerializeFMUstate: these bytes are not a state of this FMU");
}

FMI_EXPORT fmi2Status F(fmi2GetDirectionalDerivative)(void *c, const unsigned int unknowns[], size_t unknown_count,
                                                      const unsigned int knowns[], size_t known_count,
                                                      const double seed[], double result[])
{
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)result;
    return fail(c, "fmi2GetDirectionalDerivative is not provided");
}

FMI_EXPORT fmi2Status F(fmi2SetRealInputDerivatives)(void *c, const unsigned int references[], size_t count,
                                                     const int orders[], const double values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return (count == (size_t)0) ? fmi2OK : fail(c, "fmi2SetRealInputDerivatives: inputs are held, not interpolated");
}

FMI_EXPORT fmi2Status F(fmi2GetRealOutputDerivatives)(void *c, const unsigned int references[], size_t count,
                                                      const int orders[], double values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return (count == (size_t)0) ? fmi2OK : fail(c, "fmi2GetRealOutputDerivatives: outputs change by steps");
}

FMI_EXPORT fmi2Status F(fmi2DoStep)(void *c, double from, double size, int no_set_state)
{
    instance *i = (instance *)c;
    char message[MESSAGE];
    (void)no_set_state;
    if (i->m.now != STEPPING) {
        return fail(c, "fmi2DoStep comes after the initialization and before fmi2Terminate");
    }
    if (model_do_step(&i->m, from, size, message) != 0) {
        return fail(c, message);
    }
    return model_is_finite(&i->m) ? fmi2OK : say(i, fmi2Warning, NOT_FINITE);
}

FMI_EXPORT fmi2Status F(fmi2CancelStep)(void *c)
{
    return fail(c, "fmi2CancelStep: steps are not asynchronous");
}

FMI_EXPORT fmi2Status F(fmi2GetStatus)(void *c, fmi2StatusKind kind, fmi2Status *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

FMI_EXPORT fmi2Status F(fmi2GetRealStatus)(void *c, fmi2StatusKind kind, double *value)
{
    if (kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = ((const instance *)c)->m.values[TIME];
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2GetIntegerStatus)(void *c, fmi2StatusKind kind, int *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

FMI_EXPORT fmi2Status F(fmi2GetBooleanStatus)(void *c, fmi2StatusKind kind, int *value)
{
    (void)c;
    if (kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = 0;
    return fmi2OK;
}

FMI_EXPORT fmi2Status F(fmi2GetStringStatus)(void *c, fmi2StatusKind kind, const char **value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}
