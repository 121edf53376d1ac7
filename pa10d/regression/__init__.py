"""Both sides of the torque equation, as every fit and every judgement sees them."""
