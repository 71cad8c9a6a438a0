"""Solution in, missing torque as a function out."""
