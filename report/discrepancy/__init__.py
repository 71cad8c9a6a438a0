"""Findings in, pages out."""
