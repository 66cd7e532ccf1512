"""Random mutations of scenes, results and tokens, and random executors; a script and a slow test.

    python tests/api/fuzz.py --n 1000 --seed 1

Each case must end in what is right or in lines that are fit to be read, within its time. Printed is
how many did which; the exit status is 1 where one did neither.
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import json
import random
import sys
import tempfile
import time
import traceback
import warnings
import zlib
from collections import Counter
from concurrent.futures import Future
from pathlib import Path

import executors

import photizon_cl as pz
from photizon_cl.result.recipe import _PREFIX
from photizon_cl.run.recipe import Recipe
from photizon_cl.scene.files import load
from photizon_cl.scene.writing import to_json, to_toml

SECONDS = 5.0
WORDS = [
    "nan", "inf", "-1", "1e400", "0", "1e-320", "9" * 30, "true", "null", '""', '"\\u202e"', "[]",
    "{}", "[[]]", "a.b.c", "\x00", "\ufeff", "é", "=", "\n", ",", "[", "]", "{", "}", '"""', "'''",
    "[[element]]\n", "kind", "surface", '"+z"', "1979-05-27", "0x10", "#",
]  # fmt: skip


class WrongError(Exception):
    """Something was accepted that is not right, or took too long."""


def mutated(data, chance):
    """Return bytes that were changed in one to four places."""
    out = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        at, n = chance.randrange(len(out) or 1), chance.choice((1, 1, 2, 8, 64))
        how = chance.randrange(6)
        if how == 0:
            out[at : at + n] = chance.randbytes(n)
        elif how == 1:
            del out[at : at + n]
        elif how == 2:
            out[at:at] = chance.choice(WORDS).encode()
        elif how == 3:
            out[at:at] = out[at : at + n] * chance.choice((2, 50, 3000))
        elif how == 4:
            other = chance.randrange(len(out) or 1)
            out[at : at + n] = out[other : other + n]
        elif chance.random() < 0.1:
            del out[at:]
    return bytes(out)


def fit_to_read(error):
    lines = str(error).split("\n")
    if len(lines) > 100 or not all(len(line) < 2000 and line.isprintable() for line in lines):
        raise WrongError(f"a message that cannot be read: {str(error)[:300]!r}")


def a_scene(chance, folder):
    scene = load(chance.choice(("box-room", "cassegrain", "ghost-ladder", "cpc-concentrator")))
    suffix, write = chance.choice(((".toml", to_toml), (".json", to_json)))
    path = folder / f"scene{suffix}"
    path.write_bytes(mutated(write(scene).encode(), chance))
    try:
        found = load(path)
    except pz.SceneError as error:
        fit_to_read(error)
        return "refused"
    again = folder / "again.toml"
    again.write_bytes(to_toml(found).encode())
    if load(again) != found:
        raise WrongError("a scene that is read is not the one that is written")
    return "the same" if found == scene else "another valid one"


def not_ignored(what):
    """Note what fails in a destructor, where it is printed and not raised."""
    unraised.append(f"{what.exc_type.__name__}: {what.exc_value} in {what.object}")


unraised = []


def a_result(chance, folder, kept={}):  # noqa: B006  (made once)
    if not kept:
        made = pz.trace("cosine-fourth", batches=3, rays_per_batch=256)
        made.save(folder / "whole", figures=False)
        kept["data"] = (folder / "whole" / "result.nc").read_bytes()
        kept["summary"] = made.summary()
    path = folder / "result.nc"
    path.write_bytes(mutated(kept["data"], chance))
    try:
        found = pz.open_result(path)
    except pz.ResultError as error:
        fit_to_read(error)
        return "refused"
    if found.summary() != kept["summary"]:
        raise WrongError("a damaged result was believed")
    return "the same"


def a_token(chance, folder, kept={}):  # noqa: B006
    if not kept:
        made = pz.trace("box-room", batches=2, rays_per_batch=256, seed=5)
        kept["token"] = made.recipe
        kept["text"] = zlib.decompress(base64.urlsafe_b64decode(made.recipe[4:] + "=="))
        tables = {k: v for k, v in made.scene.to_dict().items() if k != "run"}
        content = json.loads(kept["text"])
        kept["tables"] = json.dumps({**content, "scene": tables}).encode()
        kept["recipe"] = Recipe.read(made.recipe)
    if chance.random() < 0.3:
        token = mutated(kept["token"].encode(), chance).decode("utf-8", "replace")
    else:
        text = mutated(kept[chance.choice(("text", "tables"))], chance)
        token = _PREFIX + base64.urlsafe_b64encode(zlib.compress(text)).rstrip(b"=").decode()
    try:
        found = Recipe.read(token)
    except pz.RecipeError as error:
        fit_to_read(error)
        if "\n" in str(error):
            raise WrongError("more than a line") from None
        return "refused"
    # what may differ: how many batches to run, what they should give, and who said so
    if found.scene.digest() != kept["recipe"].scene.digest():
        raise WrongError("a recipe of another scene")
    return "the same" if found == kept["recipe"] else "another valid one"


class Mixed:
    """Does to each task something else."""

    _max_workers = 2

    def __init__(self, chance, bad):
        self.chance, self.bad = chance, bad
        names = [*executors.WRONG.items(), *executors.LOST.items()]
        self.ways = [make() for _, make in chance.sample(names, 4)]

    def submit(self, call, task):
        future = Future()
        if self.chance.random() >= self.bad:
            future.set_result(call(task))
            return future
        how = self.chance.randrange(8)
        if how == 0:
            return future  # never
        if how == 1:
            return self.chance.choice((None, 5, "future", object()))
        if how == 2:
            raise self.chance.choice((RuntimeError, OSError, TimeoutError))("\x1bno\u202e")
        if how == 3:
            future.cancel()
            future.set_running_or_notify_cancel()
            return future
        try:
            future.set_result(self.chance.choice(self.ways)(task))
        except BaseException as error:
            future.set_exception(error)
        return future


LIMIT = 2.0


def an_executor(chance, folder, kept={}):  # noqa: B006
    settings = {"batches": 12, "rays_per_batch": 131072 if chance.random() < 0.05 else 256}
    rays = settings["rays_per_batch"]
    if rays not in kept:
        kept[rays] = pz.trace("cosine-fourth", **settings).tally_digest
    executor = Mixed(chance, chance.choice((0.1, 0.3, 0.6, 1.0)))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            found = pz.trace("cosine-fourth", max_seconds=LIMIT, executor=executor, **settings)
        except pz.RunError as error:
            fit_to_read(error)
            return "one line"
    if len(said) > 5 or not all(str(w.message).isprintable() for w in said):
        raise WrongError("warnings that cannot be read")
    if found.batches < settings["batches"]:
        if found.info.stopped != "time":
            raise WrongError("batches are missing")
        whole = pz.trace("cosine-fourth", batches=found.batches, rays_per_batch=rays)
        if whole.tally_digest != found.tally_digest:
            raise WrongError("a wrong digest")
        return "fewer batches, right"
    if found.tally_digest != kept[rays]:
        raise WrongError("a wrong digest")
    return "right, and said" if said else "right"


KINDS = {"scenes": a_scene, "results": a_result, "tokens": a_token, "executors": an_executor}


def search(kind, n, seed, folder):
    """Return how often each outcome came, and the seeds of what went wrong."""
    outcomes, wrong, longest = Counter(), [], 0.0
    KINDS[kind](random.Random(0), folder)  # what is made once takes its time
    before, sys.unraisablehook = sys.unraisablehook, not_ignored
    for case in range(seed, seed + n):
        started = time.perf_counter()
        try:
            outcomes[KINDS[kind](random.Random(case), folder)] += 1
        except Exception:
            wrong.append((case, traceback.format_exc()))
        if unraised:
            wrong.append((case, unraised.pop()))
        taken = time.perf_counter() - started
        longest = max(longest, taken)
        if taken > (1.2 * LIMIT + 2.0 if kind == "executors" else SECONDS):
            wrong.append((case, f"took {taken:.1f} s"))
    sys.unraisablehook = before
    return outcomes, wrong, longest


def main(arguments=None):
    parser = argparse.ArgumentParser()
    parser.add_argument("--n", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=KINDS, action="append")
    asked = parser.parse_args(arguments)
    failed = 0
    for kind in asked.only or KINDS:
        with tempfile.TemporaryDirectory() as folder:
            outcomes, wrong, longest = search(kind, asked.n, asked.seed, Path(folder))
        told = ", ".join(f"{n} {what}" for what, n in outcomes.most_common())
        print(f"{kind}: {asked.n} cases, {told}; {len(wrong)} wrong; longest {longest:.2f} s")
        for case, why in wrong[:5]:
            print(f"  case {case}: {why}")
        failed += len(wrong)
    return 1 if failed else 0


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        sys.exit(main())
