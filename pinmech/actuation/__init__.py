"""What a motion takes: loads, inverse dynamics with redundant drives, trajectories, sizing."""
