"""Posterior draws in, predictions out: bands, scores, the next run."""
