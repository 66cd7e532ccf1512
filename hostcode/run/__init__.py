"""A scene on a device: queue, waves, tallies, probes, paths."""
