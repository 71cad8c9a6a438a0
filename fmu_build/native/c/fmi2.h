/* Types and names of FMI 2.0.4 (Functional Mock-up Interface for Model Exchange and Co-Simulation), as far as they are used here. */
#ifndef HAPTID_FMI2_H
#define HAPTID_FMI2_H
#include <stddef.h>

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Byte;
typedef const char *fmi2String;
enum { fmi2False = 0, fmi2True = 1 };

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef struct {
    fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged;
    fmi2Boolean valuesOfContinuousStatesChanged, nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

#if defined(_WIN32)
#define FMI2 __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI2 __attribute__((visibility("default")))
#else
#define FMI2
#endif

/* Names for a program that several FMUs are linked into: -DFMI2_FUNCTION_PREFIX=joint4_ gives joint4_fmi2DoStep. As in the standard's
 * header, FMI2_OVERRIDE_FUNCTION_PREFIX takes the prefix away again. */
#if defined(FMI2_FUNCTION_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX)
#define FMI2_PASTED(a, b) a##b
#define FMI2_JOINED(a, b) FMI2_PASTED(a, b)
#define FMI2_FULL_NAME(name) FMI2_JOINED(FMI2_FUNCTION_PREFIX, name)
#define fmi2GetTypesPlatform FMI2_FULL_NAME(fmi2GetTypesPlatform)
#define fmi2GetVersion FMI2_FULL_NAME(fmi2GetVersion)
#define fmi2SetDebugLogging FMI2_FULL_NAME(fmi2SetDebugLogging)
#define fmi2Instantiate FMI2_FULL_NAME(fmi2Instantiate)
#define fmi2FreeInstance FMI2_FULL_NAME(fmi2FreeInstance)
#define fmi2SetupExperiment FMI2_FULL_NAME(fmi2SetupExperiment)
#define fmi2EnterInitializationMode FMI2_FULL_NAME(fmi2EnterInitializationMode)
#define fmi2ExitInitializationMode FMI2_FULL_NAME(fmi2ExitInitializationMode)
#define fmi2Terminate FMI2_FULL_NAME(fmi2Terminate)
#define fmi2Reset FMI2_FULL_NAME(fmi2Reset)
#define fmi2GetReal FMI2_FULL_NAME(fmi2GetReal)
#define fmi2GetInteger FMI2_FULL_NAME(fmi2GetInteger)
#define fmi2GetBoolean FMI2_FULL_NAME(fmi2GetBoolean)
#define fmi2GetString FMI2_FULL_NAME(fmi2GetString)
#define fmi2SetReal FMI2_FULL_NAME(fmi2SetReal)
#define fmi2SetInteger FMI2_FULL_NAME(fmi2SetInteger)
#define fmi2SetBoolean FMI2_FULL_NAME(fmi2SetBoolean)
#define fmi2SetString FMI2_FULL_NAME(fmi2SetString)
#define fmi2GetFMUstate FMI2_FULL_NAME(fmi2GetFMUstate)
#define fmi2SetFMUstate FMI2_FULL_NAME(fmi2SetFMUstate)
#define fmi2FreeFMUstate FMI2_FULL_NAME(fmi2FreeFMUstate)
#define fmi2SerializedFMUstateSize FMI2_FULL_NAME(fmi2SerializedFMUstateSize)
#define fmi2SerializeFMUstate FMI2_FULL_NAME(fmi2SerializeFMUstate)
#define fmi2DeSerializeFMUstate FMI2_FULL_NAME(fmi2DeSerializeFMUstate)
#define fmi2GetDirectionalDerivative FMI2_FULL_NAME(fmi2GetDirectionalDerivative)
#define fmi2EnterEventMode FMI2_FULL_NAME(fmi2EnterEventMode)
#define fmi2NewDiscreteStates FMI2_FULL_NAME(fmi2NewDiscreteStates)
#define fmi2EnterContinuousTimeMode FMI2_FULL_NAME(fmi2EnterContinuousTimeMode)
#define fmi2CompletedIntegratorStep FMI2_FULL_NAME(fmi2CompletedIntegratorStep)
#define fmi2SetTime FMI2_FULL_NAME(fmi2SetTime)
#define fmi2SetContinuousStates FMI2_FULL_NAME(fmi2SetContinuousStates)
#define fmi2GetDerivatives FMI2_FULL_NAME(fmi2GetDerivatives)
#define fmi2GetEventIndicators FMI2_FULL_NAME(fmi2GetEventIndicators)
#define fmi2GetContinuousStates FMI2_FULL_NAME(fmi2GetContinuousStates)
#define fmi2GetNominalsOfContinuousStates FMI2_FULL_NAME(fmi2GetNominalsOfContinuousStates)
#define fmi2SetRealInputDerivatives FMI2_FULL_NAME(fmi2SetRealInputDerivatives)
#define fmi2GetRealOutputDerivatives FMI2_FULL_NAME(fmi2GetRealOutputDerivatives)
#define fmi2DoStep FMI2_FULL_NAME(fmi2DoStep)
#define fmi2CancelStep FMI2_FULL_NAME(fmi2CancelStep)
#define fmi2GetStatus FMI2_FULL_NAME(fmi2GetStatus)
#define fmi2GetRealStatus FMI2_FULL_NAME(fmi2GetRealStatus)
#define fmi2GetIntegerStatus FMI2_FULL_NAME(fmi2GetIntegerStatus)
#define fmi2GetBooleanStatus FMI2_FULL_NAME(fmi2GetBooleanStatus)
#define fmi2GetStringStatus FMI2_FULL_NAME(fmi2GetStringStatus)
#endif
#endif
