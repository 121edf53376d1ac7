"""Jobs and what workers compute for them."""
