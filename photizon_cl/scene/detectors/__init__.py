"""Detectors: what is counted on an absorbing element."""

from photizon_cl.scene.detectors.detector import MAX_BINS, MAX_GENERATIONS, SIDES, Detector

__all__ = ["MAX_BINS", "MAX_GENERATIONS", "SIDES", "Detector"]
