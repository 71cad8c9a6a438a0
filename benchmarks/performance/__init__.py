"""Performance: what grows with what, and how long a user waits, measured, stored and shown in one table."""
