"""Finds where simulation and measurement disagree, and names what is missing."""

from support.environment import ready

ready()
