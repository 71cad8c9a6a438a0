"""Campaign and choices in, `Identification` out: fits, whole device and verification, written as they are made."""
