"""The motion that is asked for: trajectories, profiles, and what lies between samples."""
