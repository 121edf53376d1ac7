"""Which pa10d this is: recordings, models and reports say so."""

__version__ = "0.1.0"
