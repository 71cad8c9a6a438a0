"""Runs and noise model in, log posterior density and its mode out."""
