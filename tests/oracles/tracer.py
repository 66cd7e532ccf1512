"""A slow, obvious ray tracer: one ray at a time, textbook formulas, plain Python.

Written from the contract. It follows the very rays of the engine (the draws are keyed, so that it
can), and its tallies agree with the engine's to rounding. It knows nothing of contacts: no two
surfaces may touch, and rays that start on a surface other than the one they leave are not handled.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field, replace
from typing import Any

from oracles import philox

Vec = tuple[float, float, float]

_UNIT = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
VACUUM = "vacuum"
FRAMES = {
    "+x": ("+y", "+z"),
    "+y": ("+z", "+x"),
    "+z": ("+x", "+y"),
    "-x": ("+z", "+y"),
    "-y": ("+x", "+z"),
    "-z": ("+y", "+x"),
}
"""The contract's table: u and v of every axis."""


def axis_vector(name: str) -> Vec:
    """Return the vector of a signed axis."""
    sign = 1.0 if name[0] == "+" else -1.0
    x, y, z = _UNIT[name[1]]
    return (sign * x + 0.0, sign * y + 0.0, sign * z + 0.0)


def dot(a: Vec, b: Vec) -> float:
    """Return a·b."""
    return math.fsum(x * y for x, y in zip(a, b, strict=True))


def combine(*terms: tuple[float, Vec]) -> Vec:
    """Return a sum of multiples of vectors."""
    x, y, z = (math.fsum(k * v[i] for k, v in terms) for i in range(3))
    return (x, y, z)


def unit(a: Vec) -> Vec:
    """Return a/|a|."""
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length)


def _turn(v: Vec, about: Vec, degrees: float) -> Vec:
    """Turn by the right hand about a unit vector (Rodrigues)."""
    angle = math.radians(degrees)
    cross = (
        about[1] * v[2] - about[2] * v[1],
        about[2] * v[0] - about[0] * v[2],
        about[0] * v[1] - about[1] * v[0],
    )
    along = (1.0 - math.cos(angle)) * dot(about, v)
    return combine((math.cos(angle), v), (math.sin(angle), cross), (along, about))


def frame(row: dict[str, Any]) -> tuple[Vec, Vec, Vec]:
    """Return u, v, w of a source's or an element's table."""
    axis = row.get("axis", "+z")
    u, v = (axis_vector(name) for name in FRAMES[axis])
    w = axis_vector(axis)
    a, b = row.get("tilt_deg", (0.0, 0.0))
    if (a, b) == (0.0, 0.0):
        return u, v, w
    x, y, z = (_turn(_turn(vector, u, a), v, b) for vector in (u, v, w))
    return x, y, z


def about_normal(n: Vec, a: float, b: float, c: float) -> Vec:
    """Return a·e1 + b·e2 + c·n in the basis of Duff et al., JCGT 6(1), 2017."""
    sign = 1.0 if n[2] >= 0.0 else -1.0
    k = -1.0 / (sign + n[2])
    e1 = (1.0 + sign * n[0] * n[0] * k, sign * n[0] * n[1] * k, -sign * n[0])
    e2 = (n[0] * n[1] * k, sign + n[1] * n[1] * k, -n[1])
    return combine((a, e1), (b, e2), (c, n))


@dataclass
class Ray:
    """A ray under way."""

    number: int
    origin: Vec
    direction: Vec
    weight: float
    launched: float
    path: int = philox.ROOT
    generation: int = 0
    left: int = -1
    medium: str = VACUUM


@dataclass
class Tally:
    """Watts and counts of one batch, by element name and bin."""

    absorbed: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    escaped: float = 0.0
    killed: float = 0.0
    boosted: float = 0.0
    depth_capped: float = 0.0
    interactions: int = 0
    absorbed_in: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    wrong_media: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    power: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    ladder: dict[tuple[str, int], list[float]] = field(default_factory=lambda: defaultdict(list))
    map: dict[tuple[str, int, int], list[float]] = field(default_factory=lambda: defaultdict(list))
    far_field: dict[tuple[int, int], list[float]] = field(default_factory=lambda: defaultdict(list))


def _elements(scene: dict[str, Any]) -> list[dict[str, Any]]:
    rows = []
    for row in scene.get("element", []):
        u, v, w = frame(row)
        rows.append({**row, "u": u, "v": v, "w": w})
    return rows


def _distances(element: dict[str, Any], ray: Ray, leaving: bool) -> list[float]:
    """Return the distances at which a ray meets an element, nearest first."""
    offset = combine((1.0, ray.origin), (-1.0, tuple(element["position"])))
    if element["kind"] != "sphere":
        if leaving:
            return []
        h, dh = dot(offset, element["w"]), dot(ray.direction, element["w"])
        if dh == 0.0 or -h / dh < 0.0:
            return []
        t = -h / dh
        p = combine((1.0, offset), (t, ray.direction))
        x, y = dot(p, element["u"]), dot(p, element["v"])
        if element["kind"] == "disk":
            return [t] if math.hypot(x, y) <= element["radius"] else []
        hit = abs(x) <= element["half_width"] and abs(y) <= element["half_height"]
        return [t] if hit else []
    radius = element["radius"]
    b = dot(offset, ray.direction)
    c = dot(offset, offset) - radius * radius
    discriminant = b * b - c
    if discriminant < 0.0:
        return []
    roots = [-b - math.sqrt(discriminant), -b + math.sqrt(discriminant)]
    if leaving:  # one root is where it starts
        roots.remove(min(roots, key=abs))
    cos_port = 1.0 - 2.0 * element.get("port_fraction", 0.0)
    found = []
    for t in roots:
        p = combine((1.0, offset), (t, ray.direction))
        in_port = element.get("port_fraction") and dot(p, element["w"]) > radius * cos_port
        if t >= 0.0 and not in_port:
            found.append(t)
    return found


def nearest(elements: list[dict[str, Any]], ray: Ray) -> tuple[float, int]:
    """Return distance and number of the element hit first, (inf, −1) for none."""
    best = (math.inf, -1)
    for n, element in enumerate(elements):
        for t in _distances(element, ray, leaving=n == ray.left)[:1]:
            if t < best[0]:
                best = (t, n)
    return best


def normal_at(element: dict[str, Any], point: Vec) -> Vec:
    """Return the outward unit normal at a point of an element."""
    if element["kind"] != "sphere":
        return element["w"]
    return unit(combine((1.0, point), (-1.0, tuple(element["position"]))))


def fresnel(n1: float, n2: float, cos_i: float) -> tuple[float, float]:
    """Return (R, cos θt) for unpolarised light; R = 1 beyond the critical angle."""
    sin_t = n1 / n2 * math.sqrt(max(0.0, 1.0 - cos_i * cos_i))
    if sin_t >= 1.0:
        return 1.0, 0.0
    cos_t = math.sqrt(1.0 - sin_t * sin_t)
    rs = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t)
    rp = (n1 * cos_t - n2 * cos_i) / (n1 * cos_t + n2 * cos_i)
    return 0.5 * (rs * rs + rp * rp), cos_t


def launch(scene: dict[str, Any], number: int, index: int, rays: list[int], seed: int) -> Ray:
    """Return ray `index` of a batch, ray `number` of the run."""
    of_source = [k for k, n in enumerate(rays) for _ in range(n)][index]
    source, n = scene["source"][of_source], rays[of_source]
    u, v = philox.draw(seed, number, philox.ROOT, 0, philox.DIRECTION)
    pu, pv = philox.draw(seed, number, philox.ROOT, 0, philox.POSITION)
    position = tuple(source["position"])
    fu, fv, fw = frame(source)
    cosine = (
        math.sqrt(u) * math.cos(2.0 * math.pi * v),
        math.sqrt(u) * math.sin(2.0 * math.pi * v),
        math.sqrt(1.0 - u),
    )
    if source["kind"] in ("collimated-disk", "lambertian-disk"):
        r, phi = source["radius"] * math.sqrt(pu), 2.0 * math.pi * pv
        position = combine((1.0, position), (r * math.cos(phi), fu), (r * math.sin(phi), fv))
    if source["kind"] == "isotropic-point":
        direction = _on_sphere(u, v)
    elif source["kind"] == "collimated-disk":
        direction = fw
    elif source["kind"] == "lambertian-sphere":
        normal = _on_sphere(pu, pv)
        position = combine((1.0, position), (source["radius"], normal))
        direction = about_normal(normal, *cosine)
    else:
        direction = combine((cosine[0], fu), (cosine[1], fv), (cosine[2], fw))
    weight = source["flux"] / n
    medium = source.get("medium", VACUUM)
    return Ray(number, position, direction, weight, weight, medium=medium)


def _on_sphere(u: float, v: float) -> Vec:
    z, phi = 1.0 - 2.0 * u, 2.0 * math.pi * v
    s = math.sqrt(max(0.0, 1.0 - z * z))
    return (s * math.cos(phi), s * math.sin(phi), z)


def trace(scene: dict[str, Any], rays: list[int], seed: int, batch: int = 0) -> Tally:
    """Trace one batch of a scene given as a file's tables.

    Parameters
    ----------
    scene : dict
        Tables of a scene file, ``[run]`` included.
    rays : list of int
        Rays that each source launches.
    seed, batch : int
        Which stream.
    """
    tally, elements, run = Tally(), _elements(scene), scene["run"]
    media = {VACUUM: {"index": 1.0}, **{row["name"]: row for row in scene.get("medium", [])}}
    for index in range(sum(rays)):
        waiting = [launch(scene, batch * sum(rays) + index, index, rays, seed)]
        while waiting:
            ray = waiting.pop()
            t, n = nearest(elements, ray)
            alpha = media[ray.medium].get("absorption_per_m", 0.0)
            if alpha:
                left = ray.weight * math.exp(-alpha * t)
                tally.absorbed_in[ray.medium] += ray.weight - left
                ray = replace(ray, weight=left)
                if not left:
                    continue
            if n < 0:
                tally.escaped += ray.weight
                _count_escape(tally, scene, ray)
                continue
            tally.interactions += 1
            point = combine((1.0, ray.origin), (t, ray.direction))
            for child in _interact(tally, elements, media, n, point, ray, seed):
                if child.generation >= run["generation_cap"]:
                    tally.depth_capped += child.weight
                elif _plays_on(tally, child, _floor(run), seed):
                    waiting.append(child)
    return tally


def _interact(
    tally: Tally,
    elements: list[dict[str, Any]],
    media: dict[str, Any],
    n: int,
    point: Vec,
    ray: Ray,
    seed: int,
) -> list[Ray]:
    element = elements[n]
    surface = element["surface"]
    normal = normal_at(element, point)
    cosine = dot(ray.direction, normal)
    on = replace(ray, origin=point, generation=ray.generation + 1, left=n)
    if surface["kind"] == "absorber":
        tally.absorbed[element["name"]] += ray.weight
        _count_arrival(tally, element, point, cosine, ray)
        return []
    mirrored = unit(combine((1.0, ray.direction), (-2.0 * cosine, normal)))
    if surface["kind"] == "fresnel":
        behind = on
        if "medium" in surface:
            sides = surface.get("medium_outside", VACUUM), surface["medium"]
            near, far = sides if cosine < 0.0 else sides[::-1]
            tally.wrong_media[element["name"]] += near != ray.medium
            n1, n2 = media[near]["index"], media[far]["index"]
            behind = replace(on, medium=far)
        else:
            inside, outside = surface["index"], surface.get("index_outside", 1.0)
            n1, n2 = (outside, inside) if cosine < 0.0 else (inside, outside)
        reflectance, cos_t = fresnel(n1, n2, abs(cosine))
        if reflectance == 1.0:
            return [replace(on, direction=mirrored)]
        along = math.copysign(cos_t, cosine) - n1 / n2 * cosine
        bent = unit(combine((n1 / n2, ray.direction), (along, normal)))
        reflected = ray.weight * reflectance
        if reflected == 0.0:
            return [replace(behind, direction=bent)]
        return [
            replace(behind, direction=bent, weight=ray.weight - reflected, path=2 * ray.path),
            replace(on, direction=mirrored, weight=reflected, path=2 * ray.path + 1),
        ]
    weight = ray.weight * surface["reflectance"]
    tally.absorbed[element["name"]] += ray.weight - weight
    if weight == 0.0:
        return []
    if surface["kind"] == "mirror":
        return [replace(on, direction=mirrored, weight=weight)]
    u, v = philox.draw(seed, ray.number, ray.path, ray.generation, philox.SCATTER)
    side = -1.0 if cosine > 0.0 else 1.0
    facing = (side * normal[0], side * normal[1], side * normal[2])
    r, phi = math.sqrt(u), 2.0 * math.pi * v
    scattered = about_normal(facing, r * math.cos(phi), r * math.sin(phi), math.sqrt(1.0 - u))
    return [replace(on, direction=scattered, weight=weight)]


def _floor(run: dict[str, Any]) -> float:
    """Return the roulette floor; where it is automatic, that of a scene that does not split."""
    floor = run.get("roulette_floor", "auto")
    return 0.0 if floor == "auto" else floor


def _plays_on(tally: Tally, ray: Ray, floor: float, seed: int) -> bool:
    if ray.weight >= floor * ray.launched:
        return True
    u, _ = philox.draw(seed, ray.number, ray.path, ray.generation, philox.ROULETTE)
    if u >= 0.5:
        tally.killed += ray.weight
        return False
    tally.boosted += ray.weight
    ray.weight *= 2.0
    return True


def _bin(x: float, low: float, high: float, n: int) -> int:
    return min(max(math.floor((x - low) / (high - low) * n), 0), n - 1)


def _azimuth_bin(x: float, y: float, n: int) -> int:
    if x == y == 0.0:  # a pole has no azimuth
        return 0
    return _bin(math.atan2(y, x) % (2.0 * math.pi), 0.0, 2.0 * math.pi, n)


def _count_escape(tally: Tally, scene: dict[str, Any], ray: Ray) -> None:
    if "far_field" not in scene:
        return
    n_mu = scene["far_field"].get("n_mu", 40)
    n_phi = scene["far_field"].get("n_phi", 32)
    x, y, z = ray.direction
    place = (_bin(z, -1.0, 1.0, n_mu), _azimuth_bin(x, y, n_phi))
    tally.far_field[place].append(ray.weight)


def _count_arrival(
    tally: Tally, element: dict[str, Any], point: Vec, cosine: float, ray: Ray
) -> None:
    if "detector" not in element:
        return
    detector, name = element["detector"], element["name"]
    sphere = element["kind"] == "sphere"
    wants_plus = not sphere or detector.get("side", "inside") == "outside"
    if (cosine < 0.0) != wants_plus:
        return
    tally.power[name].append(ray.weight)
    if "generations" in detector:
        entry = min(ray.generation, detector["generations"] - 1)
        tally.ladder[name, entry].append(ray.weight)
    if "map" in detector:
        nx, ny = detector["map"]
        p = combine((1.0, point), (-1.0, tuple(element["position"])))
        x, y = dot(p, element["u"]), dot(p, element["v"])
        if sphere:
            r = element["radius"]
            place = (_azimuth_bin(x, y, nx), _bin(dot(p, element["w"]), -r, r, ny))
        else:
            a = element.get("half_width", element.get("radius"))
            b = element.get("half_height", element.get("radius"))
            place = (_bin(x, -a, a, nx), _bin(y, -b, b, ny))
        tally.map[(name, *place)].append(ray.weight)
