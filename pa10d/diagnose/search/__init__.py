"""Which effects are missing: every candidate, forward and backward, and the versions it makes."""
