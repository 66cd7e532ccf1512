"""A scene drawn before any run, with the paths of a few rays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from photizon_cl.errors import ArgumentError, show
from photizon_cl.scene.files import load

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from hostcode.device.device import DeviceRecord
    from photizon_cl.scene.model import Scene

__all__ = ["COLOURED_BY", "draw"]

COLOURED_BY: Final = ("generation", "weight")
"""What may colour the rays."""


def draw(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    rays: int = 50,
    seed: int | None = None,
    *,
    by: str = "generation",
    device: DeviceRecord | str | int | None = None,
) -> Figure:
    """Draw a scene: three sections and a view in space, with the paths of a few rays.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene, or what `photizon_cl.load` makes one of.
    rays : int, optional
        Launched rays, as `photizon_cl.paths` takes them; 0 draws none and needs no device.
    seed : int, optional
        The random stream; default that of the scene's ``[run]``.
    by : str, optional
        What colours the rays: ``"generation"`` or ``"weight"``.
    device : str, int or DeviceRecord, optional
        As in `photizon_cl.trace`.

    Returns
    -------
    matplotlib.figure.Figure
        To be changed, shown (a notebook does so by itself) or saved.

    Raises
    ------
    SceneError, ArgumentError
        Where the scene or an argument is not valid.
    RunError
        Where there is no usable device, or it fails.
    """
    if by not in COLOURED_BY:
        raise ArgumentError(
            f"by: found {show(by)}, expected one of {', '.join(map(show, COLOURED_BY))}"
        )
    loaded = load(scene)
    from photizon_cl.run.pathing import paths
    from photizon_cl.views.drawing.plot import draw_scene  # matplotlib

    if isinstance(rays, int) and not isinstance(rays, bool) and rays == 0:
        return draw_scene(loaded, by)
    return draw_scene(paths(loaded, rays, seed, device=device), by)
