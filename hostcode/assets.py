"""Where the kernel sources lie: inside the package in a wheel, beside it in a checkout."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from hostcode.errors import HostError

__all__ = ["kernels_dir"]


@cache
def kernels_dir() -> Path:
    """Return the directory of the kernel templates.

    Returns
    -------
    Path
        Absolute path of the directory that holds ``lib/``, ``stages/`` and the others.

    Raises
    ------
    HostError
        If neither the installed package nor a checkout around it holds the directory.
    """
    package = Path(__file__).resolve().parent
    places = (package / "kernels", package.parent / "kernels")
    for place in places:
        if (place / "stages").is_dir():
            return place
    looked = " and ".join(str(place) for place in places)
    raise HostError(
        f"kernel sources not found (looked for stages/ in {looked}): "
        "the installation is incomplete; install photizon-cl again"
    )
