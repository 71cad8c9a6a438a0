"""The same for runs under position control, whose torque is the residual."""
