"""Blind studies of the search for missing effects: work through cases, score, page."""
