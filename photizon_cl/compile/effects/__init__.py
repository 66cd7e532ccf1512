"""Effects: the named pieces of physics and bookkeeping that cost time on the device.

A scene compiles exactly the effects that it uses; `EFFECTS` lists every one that exists, with what
it is and what it costs. Which of them a scene needs is decided where it is compiled.
"""

from photizon_cl.compile.effects.table import EFFECTS, Effect

__all__ = ["EFFECTS", "Effect"]
