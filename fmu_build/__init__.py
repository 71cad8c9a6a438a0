"""`Equations` and `Kernel` in, FMU out: by pythonfmu or as native code."""

from haptid.support.installing.environment import ready

ready()
