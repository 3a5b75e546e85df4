"""A rod held at both ends, against obstacles with friction: certified static equilibria."""
