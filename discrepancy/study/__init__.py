"""Runs and base equations in, `Study` out: residual channels and simulators of candidates."""
