"""Fits of simulated to measured positions, joint by joint in locking order."""

from support.environment import ready

ready()
