"""Device in, `Equations` and `Kernel` out: rigid body, friction and effects from one symbolic source."""

from haptid.support.installing.environment import ready

ready()
