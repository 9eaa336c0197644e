"""What a mechanism can do: singularities, mobility and screws of a closed state."""
