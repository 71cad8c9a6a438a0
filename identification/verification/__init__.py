"""Identified device and runs with all joints free in, what it misses out."""
