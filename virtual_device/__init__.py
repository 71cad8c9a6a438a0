"""Truth in, synthetic campaigns out, by own equations and integrator; it knows no model."""

from support.installing.environment import ready

ready()
