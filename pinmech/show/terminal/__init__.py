"""The terminal: tables, progress, lines."""
