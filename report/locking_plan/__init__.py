"""Locking plan in, page and text out."""
