"""The machine: arm, joint, friction and disturbances in C, its true numbers."""
