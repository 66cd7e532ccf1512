"""The verb ``stability``, see `photizon_cl.stability`."""

from photizon_cl.stability import add_arguments
from photizon_cl.stability import run as call

__all__ = ["add_arguments", "call"]
