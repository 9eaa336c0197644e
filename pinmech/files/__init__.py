"""What is written: whole files or none, under names that stay in their folder."""
