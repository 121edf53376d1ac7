"""A weighing: the guided way from an arm and a few known weights to the scale of its torques."""
