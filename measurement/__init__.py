"""Measurement campaigns: reading and checking; the only data input and output."""

from support.environment import ready

ready()
