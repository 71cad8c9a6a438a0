"""Scalars for rigid bodies: vectors, exact trigonometric polynomials, rational rotations, numbers, expression tapes."""
