"""Plots through matplotlib, which is loaded when the first figure is made."""
