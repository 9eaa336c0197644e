"""What the user wrote: the schema, YAML with its lines, URDF, where shipped files lie."""
