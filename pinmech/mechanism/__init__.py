"""What a mechanism is: the description file, its loader, the closures, the frozen Mechanism."""
