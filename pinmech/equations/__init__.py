"""What holds at one configuration: residuals, Jacobians, Newton, continuation, limits, labels."""
