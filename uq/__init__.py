"""`Fit` and `Run`s in, `Posterior` out: density, sampling, predictive checks."""

from support.installing.environment import ready

ready("posterior")
