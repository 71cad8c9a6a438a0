"""The environment: what is missing, what the lock file holds, where it comes from."""
