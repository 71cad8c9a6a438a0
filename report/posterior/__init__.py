"""Posteriors in, page out."""
