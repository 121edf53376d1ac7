"""The control process: a fixed-rate loop that holds and moves the arm, and the one torque exit."""
