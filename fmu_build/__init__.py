"""Packaging: a compiled kernel becomes an FMU, by pythonfmu or as native code."""

from support.environment import ready

ready()
