"""Motions for experiments: what they are, how they are found, and whether the arm may make them."""
