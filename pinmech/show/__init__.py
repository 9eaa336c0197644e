"""To look at: meshcat scenes, plots, tables, reports."""
