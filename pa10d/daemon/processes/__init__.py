"""Processes that the daemon starts, watches and ends."""
