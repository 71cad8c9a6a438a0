"""Fit in, figures out: covariance, scores, identifiability, profiles, jackknife."""
