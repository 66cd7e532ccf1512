"""What a user writes: the scene, its settings and all it can hold, in Python and in files."""
