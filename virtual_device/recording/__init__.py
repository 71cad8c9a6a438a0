"""Tests of the machine: torques, sensors, campaigns on disk."""
