"""From a scene to the tables that a device reads."""
