"""Columns as a data frame of pandas, which the project itself does without."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from photizon_cl.errors import PhotizonError

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

__all__ = ["data_frame_of"]


def data_frame_of(columns: Mapping[str, list[Any]]) -> pd.DataFrame:
    """Return columns as a data frame.

    Raises
    ------
    PhotizonError
        Where pandas is not installed.
    """
    try:
        import pandas
    except ImportError as error:
        raise PhotizonError(
            "data frames need pandas, which is not installed (photizon_cl itself does without): "
            "run `pip install pandas`"
        ) from error
    return pandas.DataFrame(columns)
