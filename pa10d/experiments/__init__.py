"""Running experiments: pre-check, motion for the loop, analysis, recommendation."""
