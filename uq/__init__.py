"""Posterior sampling, diagnostics and predictive checks."""
