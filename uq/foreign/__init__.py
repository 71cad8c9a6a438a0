"""Calibrated FMU in, posterior of its parameters out."""
