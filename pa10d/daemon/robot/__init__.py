"""The robot as the daemon sees it."""
