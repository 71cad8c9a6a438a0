"""Posterior sampling, diagnostics and predictive checks."""

from support.environment import ready

ready("posterior")
