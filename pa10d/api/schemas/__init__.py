"""What goes over the wire, with examples; SI units, joints numbered from 1."""
