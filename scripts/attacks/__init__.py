"""What ``scripts/reliability.py`` does to a daemon, a kind of attack per module."""
