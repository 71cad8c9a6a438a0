"""`Fit` and `Run`s in, `Finding` out: detect, propose, refit, judge, name what is missing."""

from haptid.support.installing.environment import ready

ready()
