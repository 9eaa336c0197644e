"""meshcat: bodies, pages, animations."""
