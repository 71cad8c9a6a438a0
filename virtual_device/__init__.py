"""Truth in, synthetic campaigns out, by own equations and integrator; it knows no model."""

from haptid.support.installing.environment import ready

ready()
