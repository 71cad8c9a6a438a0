"""The one symbolic source: device, rigid body, LuGre friction, effects, equations, kernel."""

from support.environment import ready

ready()
