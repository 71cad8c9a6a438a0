"""campaign.toml and tables in, `Campaign` out: keys, columns and files, checked to the last cell."""
