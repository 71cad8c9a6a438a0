"""Residuals of runs in, noise models out: correlation, amplitude scatter, whitening, restricted likelihood."""
