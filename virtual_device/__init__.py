"""An independent truth with own equations and integrator; it makes synthetic campaigns and knows no model."""

from support.environment import ready

ready()
