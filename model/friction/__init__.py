"""Friction laws of a joint."""
