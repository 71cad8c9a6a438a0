"""Density in, chains out."""
