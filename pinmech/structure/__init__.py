"""What is connected: tree, closures, limbs; no configuration yet."""
