"""`Equations` and `Kernel` in, FMU out: by pythonfmu or as native code."""

from support.installing.environment import ready

ready()
