"""Small FMUs of FMI 2.0, compiled for this machine, whose step does what a test asks for."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy

from haptid.model.kernel.compiler import compile_shared

NAMES = (
    "GetTypesPlatform",
    "GetVersion",
    "SetDebugLogging",
    "Instantiate",
    "FreeInstance",
    "SetupExperiment",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "Terminate",
    "Reset",
    "GetReal",
    "GetInteger",
    "GetBoolean",
    "GetString",
    "SetReal",
    "SetInteger",
    "SetBoolean",
    "SetString",
    "GetFMUstate",
    "SetFMUstate",
    "FreeFMUstate",
    "SerializedFMUstateSize",
    "SerializeFMUstate",
    "DeSerializeFMUstate",
    "GetDirectionalDerivative",
    "SetRealInputDerivatives",
    "GetRealOutputDerivatives",
    "DoStep",
    "CancelStep",
    "GetStatus",
    "GetRealStatus",
    "GetIntegerStatus",
    "GetBooleanStatus",
    "GetStringStatus",
)
OWN = {
    "GetVersion": 'const char *fmi2GetVersion(void) { return "2.0"; }',
    "GetTypesPlatform": 'const char *fmi2GetTypesPlatform(void) { return "default"; }',
    "Instantiate": "void *fmi2Instantiate(void) { return &x; }",
    "GetReal": "int fmi2GetReal(void *c, const unsigned *r, size_t n, double *v) "
    "{ for (size_t i = 0; i < n; i++) v[i] = r[i] ? x : u; return 0; }",
    "SetReal": "int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *v) "
    "{ for (size_t i = 0; i < n; i++) if (r[i]) x = v[i]; else u = v[i]; return 0; }",
}
STEPS = {
    "integrates": "x += h * u; return 0;",
    "crashes": "volatile int *p = 0; *p = 1; return 0;",
    "aborts": "abort();",
    "wears out": "const char *n = getenv(\"SMALL_RUNS\"); char now[2] = {n ? *n : 'a', 0}; "
    "if (t == 0.0) { if (*now == 'd') abort(); ++*now; setenv(\"SMALL_RUNS\", now, 1); } x += h * u; return 0;",
    "exits": "exit(0);",
    "hangs": "for (volatile int i = 0;; i++) {} return 0;",
    "prints": 'for (int i = 0; i < 200000; i++) fprintf(i % 2 ? stderr : stdout, "a line without end\\n"); '
    "x += h * u; return 0;",
    "reports an error": "return 3;",
    "divides by zero": "x = (t < 0.4 ? 1.0 : 0.0) / (t < 0.4 ? 1.0 : 0.0); return 0;",
    "refuses": "if (x > 5.0) return 3; x += h * u; return 0;",
    "overflows": "x = (t < 0.4 ? 1.0 : 1e308 * 1e10); return 0;",
}
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="small" guid="{0}">
<CoSimulation modelIdentifier="small" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>
<ScalarVariable name="force" valueReference="0" causality="input" variability="continuous"><Real start="0"/>
</ScalarVariable>
<ScalarVariable name="position" valueReference="1" causality="output" variability="continuous" initial="exact">
<Real start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


def source(step: str) -> str:
    """Return the C source of an FMU whose doStep has this body."""
    rest = "\n".join(f"int fmi2{name}(void) {{ return 0; }}" for name in NAMES if name not in (*OWN, "DoStep"))
    own = "\n".join(OWN.values())
    head = "#include <stdio.h>\n#include <stdlib.h>\n#include <stddef.h>\n#pragma GCC visibility push(default)\n"
    return (
        f"{head}\nstatic double x, u;\n{own}\n{rest}\nint fmi2DoStep(void *c, double t, double h, int k) {{ {step} }}\n"
    )


def content(step: str = "integrates") -> dict[str, bytes]:
    """Return name to content of a small FMU's archive."""
    library = compile_shared({"small.c": source(STEPS[step])}, main=("small.c",))
    binary = f"binaries/{fmpy.platform}/small{fmpy.sharedLibraryExtension}"
    return {"modelDescription.xml": DESCRIPTION.encode(), binary: library.read_bytes()}


def write(path: Path, files: dict[str, bytes]) -> Path:
    """Write the archive."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path
