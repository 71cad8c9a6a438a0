"""Effects in friction."""
