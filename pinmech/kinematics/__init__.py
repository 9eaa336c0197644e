"""Where a mechanism is: closed states, forward and inverse kinematics, rates and Jacobians."""
