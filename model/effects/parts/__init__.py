"""Formulas that several effects share."""
