"""Effects between torque command and joint."""
