"""Studies of scenes."""
