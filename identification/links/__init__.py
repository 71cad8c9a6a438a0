"""Fitted coefficients in, physical links out."""
