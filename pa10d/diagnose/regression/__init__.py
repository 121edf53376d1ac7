"""The model at hand as least squares: both sides, its columns, its fit, what a candidate adds."""
