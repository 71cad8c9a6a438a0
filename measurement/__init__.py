"""Measurement campaigns: reading and checking; the only data input and output."""
