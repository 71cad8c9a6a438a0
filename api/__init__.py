"""The Python API: data frames or a campaign in; fits, posteriors, findings, tables, plots and FMUs out."""
