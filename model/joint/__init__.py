"""Device, free joints and posture in, `Equations` out, with friction and effects."""
