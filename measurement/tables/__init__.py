"""Table of a run in, its columns as numbers out: CSV or Parquet, checked for damage and layout."""
