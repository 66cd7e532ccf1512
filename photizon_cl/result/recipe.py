"""Recipes: a short text from which a run can be made again, bit for bit.

A token holds the scene (a preset's name where it is one, with its digest), the settings that the
bits depend on, the number of batches, the tally digest to expect, and the versions that made it:
``pz1-``, then base64 (URL alphabet, no padding) of a zlib stream, whose checksum tells a damaged
token. The device, threads and time are not in it: no bit depends on them.
"""

from __future__ import annotations

import base64
import binascii
import dataclasses
import json
import re
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Self

from hostcode.program.precision import PRECISIONS
from photizon_cl.errors import RecipeError, RunError, SceneError, show
from photizon_cl.result.engine import engine_digest
from photizon_cl.scene.files import load
from photizon_cl.scene.limits import LARGEST_FILE, json_excess
from photizon_cl.scene.model import Scene
from photizon_cl.scene.presets import preset_names
from photizon_cl.scene.reader import read_scene
from photizon_cl.scene.sweep_values import plain_value
from photizon_cl.version import __version__

if TYPE_CHECKING:
    from photizon_cl.result.estimates import Estimates

__all__ = ["RecipeText"]

_PREFIX: Final = "pz1-"
_BITS: Final = ("seed", "rays_per_batch", "generation_cap", "roulette_floor")
"""Settings that the bits of a batch depend on."""
_ASKED: Final = (("effects", None), ("splitting", True), ("polarisation", False))
"""More of them and their defaults, which stand in a recipe only where they are something else."""


@dataclass(frozen=True)
class RecipeText:
    """How to make a result again, as a text.

    Parameters
    ----------
    scene : Scene
        As run.
    batches : int
        Batches in all.
    precision : str
        ``fp64``, ``mixed`` or ``fp32``.
    tally_digest : str
        What the run must give.
    version, engine : str
        The version of photizon_cl, and `engine_digest`, that made the result.
    """

    scene: Scene
    batches: int
    precision: str
    tally_digest: str
    version: str = __version__
    engine: str = dataclasses.field(default_factory=engine_digest)

    @classmethod
    def of(cls, result: Estimates) -> Self:
        """Return the recipe of a result."""
        info = result.info
        return cls(
            result.scene, result.batches, info.precision, result.tally_digest, info.version,
            info.engine,
        )  # fmt: skip

    @property
    def token(self) -> str:
        """The recipe as one word of ASCII."""
        preset = next((n for n in preset_names() if _alike(load(n), self.scene)), None)
        run = {name: getattr(self.scene.run, name) for name in _BITS}
        for name, usual in _ASKED:
            if (value := getattr(self.scene.run, name)) != usual:
                run[name] = value
        tables = {k: v for k, v in self.scene.to_dict().items() if k not in ("run", "notes")}
        content = {
            "scene": tables if preset is None else preset,
            "scene_digest": self.scene.digest(),
            "run": run,
            "batches": self.batches,
            "precision": self.precision,
            "tally": self.tally_digest.removeprefix("sha256:"),
            "version": self.version,
            "engine": self.engine,
        }
        text = json.dumps(
            plain_value(content), separators=(",", ":"), ensure_ascii=True, allow_nan=False
        )
        packed = zlib.compress(text.encode("ascii"), 9)
        return _PREFIX + base64.urlsafe_b64encode(packed).rstrip(b"=").decode("ascii")

    @classmethod
    def read(cls, token: str) -> Self:
        """Return the recipe that a token holds.

        Raises
        ------
        RecipeError
            Where it is no token, or damaged, or its scene is not what it was.
        """
        if not isinstance(token, str):
            raise RecipeError(f"recipe: found {show(token)}, expected the text of a token")
        content = _unpack("".join(token.split()))
        try:
            scene = _scene(content)
            batches, tally = content["batches"], content["tally"]
            if type(batches) is not int or batches < 1:
                raise ValueError(f"batches {show(batches)}")
            if not (isinstance(tally, str) and re.fullmatch("[0-9a-f]{64}", tally)):
                raise ValueError(f"tally {show(tally)}")
            if content["precision"] not in PRECISIONS:
                raise ValueError(f"precision {show(content['precision'])}")
            made = cls(
                scene, batches, str(content["precision"]), f"sha256:{tally}",
                str(content["version"]), str(content["engine"]),
            )  # fmt: skip
        except RecipeError:
            raise
        except SceneError as error:
            lines = str(error).split("\n")
            more = f" (and {len(lines) - 1} more problems)" if len(lines) > 1 else ""
            raise RecipeError(f"recipe: its scene is not valid here: {lines[0]}{more}") from None
        except (KeyError, TypeError, ValueError) as error:
            raise RecipeError(
                f"recipe: made by another version of photizon_cl, or by hand ({_clean(error)})"
            ) from None
        return made

    def differs(self, result: Estimates) -> str:
        """Say why a result is not what the recipe tells; empty where it is, bit for bit."""
        if result.tally_digest == self.tally_digest:
            return ""
        if result.batches != self.batches:
            return f"the run ended after {result.batches} of {self.batches} batches"
        found = f"the tally digest is {result.tally_digest}, the recipe's {self.tally_digest}: "
        if self.engine != engine_digest():
            return found + (
                f"it was made by {_made(self.version, self.engine)}, and this is "
                f"{_made(__version__, engine_digest())}; install that version to get its bits"
            )
        if self.version != __version__:
            return found + (
                "the engine is the same, but it was made by photizon_cl "
                f"{_clean(self.version)} and this is {__version__}; install that one for its bits"
            )
        if not result.info.portable:
            return found + (
                f"this device does not promise the bits of {self.precision}, see `photizon devices`"
            )
        return found + (
            "version and engine are the same, so one of the two devices computes wrongly: "
            "`photizon devices` tests them; please report this"
        )

    def check(self, result: Estimates) -> None:
        """Raise where a result is not what the recipe tells.

        Raises
        ------
        RunError
            With the reason of `differs`.
        """
        why = self.differs(result)
        if why:
            raise RunError(f"not reproduced: {why}")


def _clean(text: object) -> str:
    """Return what somebody's token says, fit for a terminal."""
    return show(str(text))[1:-1]


def _made(version: str, engine: str) -> str:
    if not version:
        return "an earlier version of photizon_cl that did not note itself"
    return f"photizon_cl {_clean(version)} with the engine {_clean(engine)}"


def _alike(preset: Scene, scene: Scene) -> bool:
    """Say whether two scenes differ in nothing but how they are run."""
    one, other = preset.to_dict(), scene.to_dict()
    return {**one, "run": None} == {**other, "run": None}


def _unpack(token: str) -> dict[str, Any]:
    shown = show(token if len(token) <= 40 else f"{token[:24]}…{token[-8:]}")
    if not token.startswith(_PREFIX):
        raise RecipeError(
            f"recipe: found {shown}, expected a token that begins with {_PREFIX} "
            "(`photizon recipe DIR` prints it), or a file that holds one"
        )
    if len(token) > LARGEST_FILE:
        raise RecipeError(f"recipe: found {shown}, a token of {len(token)} characters: too many")
    try:
        body = token[len(_PREFIX) :].encode("ascii")
        packed = base64.b64decode(body + b"=" * (-len(body) % 4), altchars=b"-_", validate=True)
        unpacking = zlib.decompressobj()
        data = unpacking.decompress(packed, LARGEST_FILE)
        if unpacking.unconsumed_tail:
            raise RecipeError(
                f"recipe: found {shown}, which unpacks to more than {LARGEST_FILE} bytes: no scene "
                "is so large"
            )
        if not unpacking.eof or unpacking.unused_data:
            raise ValueError("not one whole stream")
        text = data.decode("ascii")
        found, most = json_excess(text)
        if found:
            raise RecipeError(f"recipe: found {shown}, which holds {found}, expected {most}")
        content = json.loads(text)
        if not isinstance(content, dict):
            raise ValueError("no table")
    except (ValueError, binascii.Error, zlib.error, UnicodeError, RecursionError):
        raise RecipeError(
            f"recipe: found {shown}, which is damaged (its checksum does not fit): copy the whole "
            "token, or use the recipe.txt of the run"
        ) from None
    return content


def _scene(content: dict[str, Any]) -> Scene:
    tables = content["scene"]
    given = {name: content["run"][name] for name in _BITS}
    given |= {name: content["run"].get(name, usual) for name, usual in _ASKED}
    if isinstance(tables, str):
        if tables not in preset_names():
            raise RecipeError(
                f"recipe: its scene is the preset {show(tables)}, which this version "
                f"({__version__}) does not have; it was made by {_clean(content['version'])}"
            )
        scene = load(tables)
    else:
        # what it may hold depends on how it is run
        run = {name: value for name, value in given.items() if value is not None}
        scene = read_scene(Scene, {**tables, "run": run})
    scene = dataclasses.replace(scene, run=dataclasses.replace(scene.run, **given))
    if scene.digest() != content["scene_digest"]:
        raise RecipeError(
            f"recipe: the preset {show(tables)} is not the scene that it was: made by photizon_cl "
            f"{_clean(content['version'])}, this is {__version__}; install that one to get its bits"
            if isinstance(tables, str)
            else "recipe: its scene does not have the digest that it says: the token was changed"
        )
    return scene
