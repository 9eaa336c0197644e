"""What a motion takes: dynamics, loads, friction, sharing."""
