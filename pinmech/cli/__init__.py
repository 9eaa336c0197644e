"""The command line: parses, calls, prints. ``pinmech --help`` says what it can do."""
