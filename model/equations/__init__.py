"""Quantities in, `Equations` out: states, inputs, outputs and parameters as SymPy, and their output injection."""
