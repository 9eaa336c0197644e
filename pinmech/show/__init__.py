"""To look at: meshcat scenes, plots, tables in the terminal, the report, records for JSON."""
