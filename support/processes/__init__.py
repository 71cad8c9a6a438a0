"""Processes and threads that end with the command."""
