"""Files in, `Campaign` of `Run`s out, checked; the only data input and output."""

from haptid.support.installing.environment import ready

ready()
