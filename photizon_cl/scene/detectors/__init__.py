"""Detectors: what is counted of what ends on an element or passes it."""

from photizon_cl.scene.detectors.detector import MAX_BINS, MAX_GENERATIONS, SIDES, Detector

__all__ = ["MAX_BINS", "MAX_GENERATIONS", "SIDES", "Detector"]
