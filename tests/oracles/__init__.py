"""Closed forms of the four mechanisms, written from geometry: they never import pinmech."""
