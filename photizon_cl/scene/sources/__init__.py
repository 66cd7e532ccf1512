"""Sources: where rays start. One class a file, listed in the registry."""

from photizon_cl.scene.sources.base import DirectedSource, Source

__all__ = ["DirectedSource", "Source"]
