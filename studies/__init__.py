"""Long studies of the product's claims; not part of the wheel."""
