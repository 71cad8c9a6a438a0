"""`Run`s and a `Simulator` in, `Fit`s out, joint by joint in locking order."""

from haptid.support.installing.environment import ready

ready()
