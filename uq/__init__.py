"""`Fit` and `Run`s in, `Posterior` out: density, sampling, predictive checks."""

from haptid.support.installing.environment import ready

ready("posterior")
