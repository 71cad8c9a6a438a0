"""Finds where simulation and measurement disagree, and names what is missing."""
