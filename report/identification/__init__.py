"""Fits in, report out."""
