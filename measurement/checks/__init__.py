"""`Campaign` in, remarks out: clocks, units, signs, what the device says; the campaign made ready for fits."""
