"""Studies: many traces of one scene, for what they say together."""
