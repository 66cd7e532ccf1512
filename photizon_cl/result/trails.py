"""Sequences of paths: the steps behind a path's key, and their words."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from photizon_cl.scene.parameter_paths import quoted

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from photizon_cl.scene.model import Scene

__all__ = ["EVENTS", "Step", "Trails", "keys_of", "words"]

EVENTS: Final = {1: "r", 2: "t", 3: "i", 4: "s"}
"""Letter of each event: reflected, transmitted, totally reflected, scattered."""
_END: Final = 15


@dataclass(frozen=True)
class Step:
    """One interaction of a path.

    Parameters
    ----------
    element, face : str
        Names.
    event : str
        ``r`` reflected, ``t`` transmitted, ``i`` totally reflected, ``s`` scattered.
    refracting : bool
        Whether the face is the border of two media.
    """

    element: str
    face: str
    event: str
    refracting: bool

    @property
    def place(self) -> str:
        """Element and face, quoted where they need it."""
        return f"{quoted(self.element)}.{quoted(self.face)}"

    def __str__(self) -> str:
        return f"{self.place} {self.event}"


@dataclass(frozen=True, eq=False)
class Trails:
    """Steps of some paths, by the paths' keys.

    Parameters
    ----------
    keys : ndarray, shape (n,), int64
        In no order.
    ends : ndarray, shape (n,), int64
        Where each one's steps end in `steps`; they begin where the one before ends.
    steps : ndarray, shape (total,), int64
        Element << 20 | name of the face << 4 | event.
    """

    keys: NDArray[np.int64]
    ends: NDArray[np.int64]
    steps: NDArray[np.int64]

    @classmethod
    def of(cls, keys: Iterable[int], found: Iterable[NDArray[np.int64] | None]) -> Trails:
        """Return the steps that were found of some paths; the others are left out."""
        pairs = [(key, steps) for key, steps in zip(keys, found, strict=True) if steps is not None]
        lengths = [len(steps) for _, steps in pairs]
        return cls(
            np.array([key for key, _ in pairs], np.int64),
            np.cumsum(lengths, dtype=np.int64),
            np.concatenate([np.empty(0, np.int64), *(steps for _, steps in pairs)]),
        )

    def and_these(self, others: Trails, keys: NDArray[np.int64]) -> Trails:
        """Return these and others, of those paths that have one of some keys."""
        known = {**self.by_key, **others.by_key}
        still = set(keys.tolist())
        wanted = [key for key in known if key in still]
        return Trails.of(wanted, [known[key] for key in wanted])

    @cached_property
    def by_key(self) -> dict[int, NDArray[np.int64]]:
        """The steps of each path."""
        begins = np.append(0, self.ends[:-1]) if len(self.ends) else self.ends
        return {
            int(key): self.steps[a:b]
            for key, a, b in zip(self.keys, begins.tolist(), self.ends.tolist(), strict=True)
        }

    def check(self, about: dict[int, int], scene: Scene) -> None:
        """See that the steps are those of their keys.

        Parameters
        ----------
        about : dict of int to int
            Detector << 32 | interactions of each key that there is.
        scene : Scene
            Whose faces they are.

        Raises
        ------
        ValueError
            Where they are not.
        """
        n, total = len(self.keys), len(self.steps)
        lengths = np.diff(np.append(0, self.ends)) if n else np.empty(0, np.int64)
        if len(self.ends) != n or (lengths < 0).any() or (n and self.ends[-1] != total):
            raise ValueError("its paths' steps do not belong together")
        if not n:
            return
        known = [about.get(int(key)) for key in self.keys]
        if any(k is None for k in known):
            raise ValueError("it has steps of paths that it has not")
        told = np.array(known, np.int64)
        if (lengths != told & 0xFFFFFFFF).any():
            raise ValueError("its paths have other numbers of interactions than of steps")
        element, face, event = _split(self.steps)
        faces = np.array([len(e.faces) for e in scene.element], np.int64)
        if total and not (
            (self.steps >= 0).all()
            and (element < len(faces)).all()
            and (face < faces[np.minimum(element, len(faces) - 1)]).all()
            and np.isin(event, list(EVENTS)).all()
        ):
            raise ValueError("its paths meet faces that the scene has not")
        if (keys_of(self.steps, self.ends, told >> 32) != self.keys).any():
            raise ValueError("its paths' steps are not those of their keys")


def _split(
    steps: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    return steps >> 20, (steps >> 4) & 0xFFFF, steps & 15


def _mixed(trail: NDArray[np.uint64], step: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return keys behind one more step, as kernels/lib/trail_key.mako makes them."""
    with np.errstate(over="ignore"):
        h = (trail ^ step) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(0x632BE59BD9B4E019)
        h = (h ^ (h >> np.uint64(32))) * np.uint64(0xD6E8FEB86659FD93)
        h = (h ^ (h >> np.uint64(29))) * np.uint64(0xD6E8FEB86659FD93)
        return np.asarray(h ^ (h >> np.uint64(32)), np.uint64)


def keys_of(
    steps: NDArray[np.int64], ends: NDArray[np.int64], detectors: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the keys of sequences.

    Parameters
    ----------
    steps, ends : ndarray, shapes (total,) and (n,), int64
        As in `Trails`.
    detectors : ndarray, shape (n,), int64
        Number of the detector that each one ends in.
    """
    begins = np.append(0, ends[:-1])
    lengths = ends - begins
    key = np.zeros(len(ends), np.uint64)
    for depth in range(int(lengths.max(initial=0))):
        longer = np.flatnonzero(lengths > depth)
        step = steps[begins[longer] + depth].astype(np.uint64)
        key[longer] = _mixed(key[longer], step)
    key = _mixed(key, (detectors << 20 | _END).astype(np.uint64))
    key[key == 0] = 1
    return key.view(np.int64)


def words(scene: Scene, steps: NDArray[np.int64], known: dict[int, Step]) -> tuple[Step, ...]:
    """Return the steps of a path by their names; `known` are those that were made before."""
    for step in set(steps.tolist()) - known.keys():
        item = scene.element[step >> 20]
        number = (step >> 4) & 0xFFFF
        refracts = item.surface_of(number).refracts
        known[step] = Step(item.name, item.face_name(number), EVENTS[step & 15], refracts)
    return tuple(known[step] for step in steps.tolist())


def sequence(steps: Sequence[Step], detector: str) -> str:
    """Return a path's sequence in words, ending in its detector's name."""
    return " > ".join([*map(str, steps), quoted(detector)])
