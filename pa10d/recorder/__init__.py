"""The recorder: drains the ring into runs, in a process of its own."""
