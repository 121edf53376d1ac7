"""What commands and HTTP routes have in common: a request in, stored things and answers out."""
