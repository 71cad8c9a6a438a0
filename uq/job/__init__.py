"""Campaign and choices in, posteriors of its joints out, one after the other, written as they are made."""
