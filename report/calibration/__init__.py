"""A calibrated FMU of others in, page out."""
