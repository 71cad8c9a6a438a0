"""Archives, parameter sets, systems; identification.json and discrepancy JSON as values of an FMU's parameters."""
