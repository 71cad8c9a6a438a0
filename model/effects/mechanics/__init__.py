"""Effects in springs, contacts, loads and transmissions."""
