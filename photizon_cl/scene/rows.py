"""Rows of the device's tables, by name.

A kind declares the columns of its row once: name, unit, meaning. Packing goes by name, and the same
declaration gives the kernels a constant for each column, ``<ROW>_<COLUMN>`` in capitals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["NO_ROW", "Column", "Row"]


@dataclass(frozen=True)
class Column:
    """A number that a kernel reads of a kind.

    Parameters
    ----------
    name : str
        Lower case, unique in its row.
    unit : str
        ``m``, ``m²``, ``1/m``, ``rad`` …; empty for a pure number.
    meaning : str
        What it is.
    """

    name: str
    unit: str
    meaning: str


class Row:
    """The columns of a kind's row.

    Parameters
    ----------
    name : str
        Prefix of the kernels' constants.
    *columns : tuple of (str, str, str)
        Name, unit and meaning of each column.
    base : Row, optional
        A row that this one goes on from: its columns come first and keep their names.
    """

    def __init__(self, name: str, *columns: tuple[str, str, str], base: Row | None = None) -> None:
        self.name = name
        self.base = base
        self.own = tuple(Column(*column) for column in columns)
        self.columns: tuple[Column, ...] = (base.columns if base else ()) + self.own
        self._names = tuple(column.name for column in self.columns)
        if len(set(self._names)) != len(self._names):
            raise ValueError(f"row {name}: a column's name is used twice: {self._names}")

    def __len__(self) -> int:
        return len(self.columns)

    def pack(self, values: Mapping[str, float]) -> list[float]:
        """Return values in the order of the columns.

        Raises
        ------
        ValueError
            Where a column has no value, or a value no column.
        """
        if len(values) != len(self._names) or not values.keys() >= set(self._names):
            missing = [name for name in self._names if name not in values]
            extra = [name for name in values if name not in self._names]
            raise ValueError(f"row {self.name}: no value for {missing}, no column for {extra}")
        return [values[name] for name in self._names]

    def constants(self, first: int) -> dict[str, int]:
        """Return the kernels' constants: name to place, for a row that begins at `first`."""
        found = self.base.constants(first) if self.base else {}
        offset = first + (len(self.base) if self.base else 0)
        found.update({f"{self.name}_{c.name.upper()}": offset + n for n, c in enumerate(self.own)})
        return found


NO_ROW = Row("NOTHING")
"""The row of a kind that the kernels read nothing of."""
