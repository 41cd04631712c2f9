/* The observer as an FMU: its variables by value reference, its steps and its states. What FMI 2.0 and 3.0 share.
 * This file belongs to whoever generated it. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "model.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define FMI_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI_EXPORT __attribute__((visibility("default")))
#else
#define FMI_EXPORT
#endif

#define PASTED(prefix, name) prefix##name
#define JOINED(prefix, name) PASTED(prefix, name)

/* Value references, as in modelDescription.xml. */
enum {
    TIME = 0,
    FIRST_U = 1,
    FIRST_Y = FIRST_U + MODEL_INPUTS,
    FIRST_XHAT = FIRST_Y + MODEL_OUTPUTS,
    FIRST_INNOVATION = FIRST_XHAT + MODEL_STATES,
    FIRST_INITIAL = FIRST_INNOVATION + MODEL_OUTPUTS,
    FIRST_R = FIRST_INITIAL + MODEL_STATES,
    VARIABLES = FIRST_R + (MODEL_FEEDBACK * MODEL_INPUTS)
};

typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED } phase;

/* All that changes. */
typedef struct {
    phase now;
    double values[VARIABLES];
    model_state observer;
} model;

enum { MESSAGE = 200, NAME = 100 };

/* In front of a serialized state. */
typedef struct {
    char token[sizeof MODEL_TOKEN];
    model state;
} serialized;

static int is_finite(double x)
{
    return (x - x) == 0.0;
}

/* A column of values in the observer's type. */
static void model_column(const model *m, int first, int count, model_number *column)
{
    int i;
    for (i = 0; i < count; ++i) {
        column[i] = (model_number)m->values[first + i];
    }
}

static void model_store(model *m, int first, int count, const model_number *column)
{
    int i;
    for (i = 0; i < count; ++i) {
        m->values[first + i] = (double)column[i];
    }
}

/* The outputs that follow from the estimate at the same instant: u = r - K xhat. */
static void model_outputs(model *m)
{
#if MODEL_FEEDBACK
    model_number u[MODEL_INPUTS];
    model_number r[MODEL_INPUTS];
    model_column(m, FIRST_R, MODEL_INPUTS, r);
    model_input(&m->observer, r, u);
    model_store(m, FIRST_U, MODEL_INPUTS, u);
#else
    (void)m;
#endif
}

/* The whole number of periods in a time that another one precedes. Returns 0, or 1 if there is none: a difference of
 * times is rounded, the more the later they are. */
static int model_periods(double from, double time, double *count)
{
    const double ratio = time / MODEL_PERIOD;
    const double rounding = 4.0 * DBL_EPSILON * ((fabs(from) + fabs(time)) / MODEL_PERIOD);
    *count = floor(ratio + 0.5);
    return (fabs(ratio - *count) <= (1e-6 + ((rounding < 0.25) ? rounding : 0.25))) ? 0 : 1;
}

/* Sets the time at which the simulation starts. Returns 0, or 1 with a message: a plant that depends on time is sampled
 * at multiples of the period. */
static int model_start(model *m, double start, char message[MESSAGE])
{
#if MODEL_TIMED
    double count;
    if ((model_periods(0.0, start, &count) != 0) || !(count >= 0.0) || !(count < 9e15)) {
        (void)snprintf(message, (size_t)MESSAGE,
                       "the plant depends on time: the start time %.17g has to be 0 or a multiple of the sampling period %.17g (seconds)",
                       start, (double)MODEL_PERIOD);
        return 1;
    }
#else
    (void)message;
#endif
    m->values[TIME] = start;
    return 0;
}

/* The observer starts from the parameters, at the start time. */
static void model_prepare(model *m)
{
    model_number initial[MODEL_STATES];
#if MODEL_TIMED
    double count;
    (void)model_periods(0.0, m->values[TIME], &count);
#endif
    model_column(m, FIRST_INITIAL, MODEL_STATES, initial);
    model_init(&m->observer, initial);
#if MODEL_TIMED
    m->observer.sample = (uint64_t)count;
#endif
    model_store(m, FIRST_XHAT, MODEL_STATES, initial);
    model_outputs(m);
}

/* Start values. */
static void model_begin(model *m)
{
    static const double initial[MODEL_STATES] = MODEL_INITIAL;
    (void)memset(m, 0, sizeof *m);
    m->now = INSTANTIATED;
    (void)memcpy(&m->values[FIRST_INITIAL], initial, sizeof initial);
    model_prepare(m);
}

/* Null if the value can be set, else the reason. */
static const char *model_set(model *m, uint32_t reference, double value)
{
    const int k = (int)reference;
    if (reference >= (uint32_t)VARIABLES) {
        return "there is no variable of this value reference";
    }
    if ((k >= FIRST_INITIAL) && (k < FIRST_R)) {
        if ((m->now != INSTANTIATED) && (m->now != INITIALIZING)) {
            return "the first estimate can be set before the initialization ends, not later";
        }
        m->values[k] = value;
        model_prepare(m);
        return NULL;
    }
    if ((k >= FIRST_R) || ((k >= (MODEL_FEEDBACK ? FIRST_Y : FIRST_U)) && (k < FIRST_XHAT))) {
        m->values[k] = value;
        model_outputs(m);
        return NULL;
    }
    return "only inputs and parameters can be set";
}

/* One period. */
static void model_advance(model *m)
{
    model_number u[MODEL_INPUTS + 1] = {(model_number)0};
    model_number y[MODEL_OUTPUTS + 1] = {(model_number)0};
    model_number xhat[MODEL_STATES];
    model_number innovation[MODEL_OUTPUTS + 1] = {(model_number)0};
    int i;
    model_column(m, FIRST_U, MODEL_INPUTS, u);
    model_column(m, FIRST_Y, MODEL_OUTPUTS, y);
    model_innovation(&m->observer, u, y, innovation);
    /* An output that was not measured has none. */
    for (i = 0; i < MODEL_OUTPUTS; ++i) {
        innovation[i] = is_finite((double)y[i]) ? innovation[i] : (model_number)0;
    }
#if MODEL_FEEDBACK
    {
        model_number r[MODEL_INPUTS];
        model_column(m, FIRST_R, MODEL_INPUTS, r);
        model_step(&m->observer, r, y, u, xhat);
    }
#else
    model_step(&m->observer, u, y, xhat);
#endif
    model_store(m, FIRST_XHAT, MODEL_STATES, xhat);
    model_store(m, FIRST_INNOVATION, MODEL_OUTPUTS, innovation);
    model_outputs(m);
}

/* As many periods as the communication step has, with the inputs held. Returns 0, or 1 with a message if the step is not
 * a multiple of the period. */
static int model_do_step(model *m, double from, double size, char message[MESSAGE])
{
    double count;
    double k;
    if ((model_periods(from, size, &count) != 0) || !(count >= 1.0)) {
        (void)snprintf(message, (size_t)MESSAGE,
                       "the communication step %.17g is not a multiple of the sampling period %.17g (seconds)", size,
                       (double)MODEL_PERIOD);
        return 1;
    }
    for (k = 0.0; k < count; k += 1.0) {
        model_advance(m);
    }
    m->values[TIME] = from + size;
    return 0;
}

static int model_is_finite(const model *m)
{
    int i;
    for (i = 0; i < MODEL_STATES; ++i) {
        if (!is_finite(m->values[FIRST_XHAT + i])) {
            return 0;
        }
    }
    return 1;
}

static const char NOT_FINITE[] =
    "the estimate is not finite; it stays so until the FMU is reset or a state is set";

/* A copy on the heap; null without memory. */
static model *model_copy(const model *m)
{
    model *copy = (model *)calloc((size_t)1, sizeof *copy);
    if (copy != NULL) {
        (void)memcpy(copy, m, sizeof *copy);
    }
    return copy;
}

static void model_serialize(const model *m, unsigned char *bytes)
{
    serialized s;
    (void)memset(&s, 0, sizeof s);
    (void)memcpy(s.token, MODEL_TOKEN, sizeof s.token);
    (void)memcpy(&s.state, m, sizeof s.state);
    (void)memcpy(bytes, &s, sizeof s);
}

/* Null if the bytes are not a state of this FMU. */
static model *model_deserialize(const unsigned char *bytes, size_t size)
{
    serialized s;
    if (size != sizeof s) {
        return NULL;
    }
    (void)memcpy(&s, bytes, sizeof s);
    if (memcmp(s.token, MODEL_TOKEN, sizeof s.token) != 0) {
        return NULL;
    }
    return model_copy(&s.state);
}

#endif
