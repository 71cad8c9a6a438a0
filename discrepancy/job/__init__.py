"""Campaign and choices in, findings out: of one joint by position or by torque, or of joints that move together."""
