"""The virtual drives: objects, state machine, wire and the motor that each turns."""
