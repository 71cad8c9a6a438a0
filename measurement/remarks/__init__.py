"""`Campaign` in, remarks on likely slips out: units, signs, columns, what the device and its controllers say."""
