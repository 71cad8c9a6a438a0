"""`Run`s and a `Simulator` in, `Fit`s out, joint by joint in locking order."""

from support.installing.environment import ready

ready()
