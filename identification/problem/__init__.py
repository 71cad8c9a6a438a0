"""Simulator, runs and options in, least-squares problem out: scaled parameters, residuals, constraints."""
