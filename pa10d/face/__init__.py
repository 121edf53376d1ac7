"""What ``import pa10d`` gives: a dozen functions and the values they take and return."""
