"""The machine: arm, joint and disturbances in C, its true numbers."""
