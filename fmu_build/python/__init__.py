"""Interface in, pythonfmu archive out, with its slave, guard and plain-Python fallback."""
