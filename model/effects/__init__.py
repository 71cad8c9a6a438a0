"""Catalogue of effects: one formula a file."""
