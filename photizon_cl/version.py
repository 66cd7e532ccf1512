"""The version of photizon_cl."""

from typing import Final

__version__: Final = "0.1.0"
