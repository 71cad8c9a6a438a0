"""Files in, `Campaign` of `Run`s out, checked; the only data input and output."""

from support.installing.environment import ready

ready()
