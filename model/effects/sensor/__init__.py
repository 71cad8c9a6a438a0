"""Effects between joint and encoder reading."""
