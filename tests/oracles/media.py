"""Stacks of layers between planes, followed by hand: what each medium takes, ray by ray."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from typing import Any

from oracles import compare, scenes, tracer
from oracles.engine import Traced, compiled, scene_of, trace, trace_compiled
from oracles.scenes import BLACK, beam, wall
from photizon_cl.scene.files import load

HALF = 1e3
"""Half the size of the plates: rays along the normal, or nearly so, never pass beside one."""


@dataclass(frozen=True)
class Layer:
    """What lies between two planes: medium, index, absorption in 1/m."""

    medium: str
    index: float
    alpha: float = 0.0


@dataclass
class Sums:
    """Where weight went, by a name: ``escaped``, ``capped``, ``in MEDIUM``, ``plate``."""

    of: dict[str, float] = field(default_factory=dict)
    interactions: int = 0

    def add(self, name: str, amount: float) -> None:
        self.of[name] = self.of.get(name, 0.0) + amount

    def __getitem__(self, name: str) -> float:
        return self.of.get(name, 0.0)


def followed(
    layers: list[Layer], planes: list[float], start: float, cap: int, plate: float | None = None
) -> Sums:
    """Follow a ray of weight 1 along +z through layers, all its children with it.

    Layer k lies between plane k − 1 and plane k; the first and last one have no end. Past the last
    plane a black plate may stand. Reflectance is ((n − n')/(n + n'))².
    """
    sums = Sums()
    first = sum(z < start for z in planes)
    waiting = [(first, start, 1, 1.0, 0)]
    while waiting:
        layer, z, way, weight, generation = waiting.pop()
        if generation == cap:
            sums.add("capped", weight)
            continue
        here = layers[layer]
        end = layer if way > 0 else layer - 1
        if 0 <= end < len(planes):
            length = abs(planes[end] - z)
        elif way > 0 and plate is not None:
            length = plate - z
        else:
            sums.add(f"in {here.medium}" if here.alpha else "escaped", weight)
            continue
        left = weight * math.exp(-here.alpha * length)
        if here.alpha:
            sums.add(f"in {here.medium}", weight - left)
        if left == 0.0:
            continue
        sums.interactions += 1
        if not 0 <= end < len(planes):
            sums.add("plate", left)
            continue
        there = layers[layer + way]
        part = ((here.index - there.index) / (here.index + there.index)) ** 2
        at = planes[end]
        waiting.append((layer + way, at, way, left * (1.0 - part), generation + 1))
        if part:
            waiting.append((layer, at, -way, left * part, generation + 1))
    return sums


def plate(index: float, alpha: float) -> list[Layer]:
    """Return the layers of a plate of glass in vacuum."""
    vacuum = Layer("vacuum", 1.0)
    return [vacuum, Layer("glass", index, alpha), vacuum]


def stack(
    layers: list[Layer], planes: list[float], start: float, plate: float | None = None, **run: Any
) -> dict[str, Any]:
    """Return the parts of such a scene, for `scene_of`: sources, elements, media and run."""
    first = sum(z < start for z in planes)
    lamp = {**beam((0, 0, start), "+z", 1e-9), "medium": layers[first].medium}
    elements = []
    for k, z in enumerate(planes):
        # the normal points up or down, by turns: what is behind it is the inside
        below, above = layers[k].medium, layers[k + 1].medium
        up = k % 2 == 0
        inside, outside = (below, above) if up else (above, below)
        surface = {"kind": "fresnel", "medium": inside, "medium_outside": outside}
        elements.append({**wall((0, 0, z), "+z" if up else "-z", HALF), "surface": surface})
    if plate is not None:
        black = {**wall((0, 0, plate), "-z", HALF), **BLACK, "detector": {}}
        elements.append({"name": "plate", **black})
    found = {layer.medium: layer for layer in layers if layer.medium != "vacuum"}
    media = [
        {"name": name, "index": layer.index, "absorption_per_m": layer.alpha}
        for name, layer in found.items()
    ]
    return {"sources": [lamp], "elements": elements, "medium": media, "run": run}


def random_stack(number: int) -> tuple[list[Layer], list[float], float, float | None]:
    """Return layers, planes, a start and perhaps a plate."""
    r = random.Random(number)
    some = [Layer("vacuum", 1.0)]
    some += [
        Layer(f"medium {n}", r.uniform(1.0, 2.5), r.choice((0.0, r.uniform(0.1, 40.0))))
        for n in range(3)
    ]
    planes = sorted(r.uniform(0.0, 0.1) for _ in range(r.randint(1, 4)))
    layers = [r.choice(some)]
    while len(layers) <= len(planes):
        layers.append(r.choice([layer for layer in some if layer != layers[-1]]))
    plate = r.choice((None, planes[-1] + r.uniform(0.01, 0.1)))
    return layers, planes, r.uniform(-0.02, planes[-1]), plate


def rows_of(found: Traced) -> dict[str, float]:
    """Return the rows of a trace in parts of what was emitted, named as `Sums` names them."""
    layout = found.compiled.layout
    rows = {}
    for row in layout.rows:
        part = found.amount(layout.row(row.name)) / found.emitted
        rows[row.title.replace("absorbed in ", "in ")] = float(part)
    rows["capped"] = rows.pop("depth-capped")
    for element in found.compiled.scene.element:
        if not element.surface.transmits:
            rows[element.name] = float(found.absorbed(element.name) / found.emitted)
    return rows


def agrees(found: Traced, sums: Sums, tolerance: float = 1e-12) -> None:
    """Assert that every row is that of the layers followed by hand, and that all closes."""
    rows = rows_of(found)
    assert set(sums.of) <= set(rows)
    for name, part in rows.items():
        assert abs(part - sums[name]) <= tolerance, name
    for closure in found.closures():
        assert abs(closure) <= 1e-15
    rays = found.compiled.settings.rays_per_batch * len(found.batches)
    assert found.interactions == rays * sums.interactions


def mismatches(found: Traced) -> list[int]:
    """Return how often rays met each element in another medium than it names."""
    group = found.compiled.layout.group("media")
    assert group is not None
    return found.cells[group.first : group.first + group.size, 3].tolist()


def random_scene(number: int, rays: int = 300) -> dict[str, Any]:
    """Return a random scene of everything whose glass is of media, and sources in some.

    Nothing sees to it that a ray is where its medium is: there are wrong ones by the hundred.
    """
    tables = scenes.random_scene(number, rays=rays)
    names = ("vacuum", "m0", "m1", "m2")
    values = ((1.2, 0.0), (1.5, 0.3), (1.9, 2.0))
    for n, element in enumerate(tables["element"]):
        if element["surface"]["kind"] == "fresnel":
            inside, outside = names[n % 4], names[(n + 1 + number % 3) % 4]
            surface = {"kind": "fresnel", "medium": inside, "medium_outside": outside}
            element["surface"] = surface
    for n, source in enumerate(tables["source"]):
        source["medium"] = names[(n + number) % 3]
    media = [
        {"name": name, "index": index, "absorption_per_m": alpha}
        for name, (index, alpha) in zip(names[1:], values, strict=True)
    ]
    return {**tables, "medium": media}


def reference_agrees(number: int, rays: int = 200) -> int:
    """Assert what the plain tracer has: rows, maps, ladders, far field, and each wrong medium.

    Return how often one was wrong.
    """
    tables = random_scene(number, rays)
    found = trace_compiled(compiled(load(tables), seed=number))
    assert compare.differences(found, tables, 1e-9) == []
    wrong_media = tracer.trace(tables, list(found.compiled.rays_of_source), number).wrong_media
    names = [element["name"] for element in tables["element"]]
    assert mismatches(found) == [wrong_media[name] for name in names]
    assert found.amount(found.compiled.layout.row("absorbed_in.m1")) > 0
    assert all(abs(closure) <= 1e-15 for closure in found.closures())
    return sum(mismatches(found))


def slab(cap: int = 60, **more: Any) -> None:
    """Gate: a slab that absorbs, with all internal reflections, and a black plate behind it."""
    layers = [Layer("air", 1.0, 0.3), Layer("glass", 1.5, 25.0), Layer("air", 1.0, 0.3)]
    planes, start, plate = [0.0, 0.01], -0.02, 0.05
    parts = stack(layers, planes, start, plate, generation_cap=cap, rays_per_batch=32)
    found = trace(scene_of(**parts), batches=2, **more)
    agrees(found, followed(layers, planes, start, cap, plate))
    assert mismatches(found) == [0, 0, 0]


def nested(cap: int = 12, **more: Any) -> None:
    """Gate: water, glass in it, a bubble in the glass, along the line through their middles."""
    water, glass, bubble = Layer("water", 1.33, 2.0), Layer("glass", 1.5, 9.0), Layer("vacuum", 1.0)
    layers, planes = [water, glass, bubble, glass, water], [-0.2, -0.1, 0.1, 0.2]
    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z"}
    lamp = {**beam((0, 0, -0.5), "+z", 1e-9), "medium": "water"}
    elements = [
        {
            **ball,
            "radius": radius,
            "surface": {"kind": "fresnel", "medium": inside, "medium_outside": outside},
        }
        for radius, inside, outside in ((0.2, "glass", "water"), (0.1, "vacuum", "glass"))
    ]
    media = [
        {"name": layer.medium, "index": layer.index, "absorption_per_m": layer.alpha}
        for layer in (glass, water)
    ]
    scene = scene_of([lamp], elements, medium=media)
    found = trace(scene, batches=2, rays_per_batch=32, generation_cap=cap, **more)
    agrees(found, followed(layers, planes, -0.5, cap))
    assert mismatches(found) == [0, 0]


def wrong(**more: Any) -> None:
    """Gate: two bodies that overlap, of index 1, so that each ray meets four faces, three wrong."""

    def slab_of(medium: str, low: float, high: float) -> list[dict[str, Any]]:
        surface = {"surface": {"kind": "fresnel", "medium": medium}}
        faces = wall((0, 0, low), "-z", HALF), wall((0, 0, high), "+z", HALF)
        return [{**face, **surface} for face in faces]

    elements = slab_of("a", 0.0, 0.2) + slab_of("b", 0.1, 0.3)
    media = [{"name": "a", "index": 1.0}, {"name": "b", "index": 1.0}]
    scene = scene_of([beam((0, 0, -1), "+z", 1e-6)], elements, medium=media)
    found = trace(scene, batches=2, rays_per_batch=50, generation_cap=8, **more)
    # from vacuum into a; in a at b's front; in b at a's back, which leads out; in vacuum at b's
    assert mismatches(found) == [0, 100, 100, 100]
    assert found.escaped == found.emitted
