"""What was measured: recordings, their samples and signals, the motion in them."""
