"""The daemon: starts and watches the other processes, keeps jobs, speaks for the robot."""
