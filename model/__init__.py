"""Device in, `Equations` and `Kernel` out: rigid body, LuGre friction and effects from one symbolic source."""

from support.installing.environment import ready

ready()
