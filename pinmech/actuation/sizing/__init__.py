"""Cases in, sizing tables out."""
