"""A scene file traced by Mitsuba 3, for test_tracers.py: a program of its own.

``by_mitsuba.py SAMPLES SEED < scene.json`` prints watts on the element ``sensor`` and their
standard error, by 16 renders of so many samples. Paths begin at the sensor, so nothing of this way
of going through a scene is ours. Needs `mitsuba` and a libLLVM, which ``DRJIT_LIBLLVM_PATH`` names
(Debian's package ``libllvm19`` has one).

What it knows: one `lambertian-disk`; rectangles, disks and spheres; `fresnel` by media, `absorber`,
`lambertian`, `mirror`, the last and black paint with a scatter.
"""

from __future__ import annotations

import json
import math
import sys
from typing import Any

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_mono")

AXES = {
    "+x": "yz", "+y": "zx", "+z": "xy", "-x": "zy", "-y": "xz", "-z": "yx",
}  # fmt: skip
GROUPS = 16
LAYERS = 4096


def unit(letter: str) -> np.ndarray:
    return np.eye(3)["xyz".index(letter)]


def frame(given: dict[str, Any]) -> np.ndarray:
    """Return u, v and axis as columns."""
    axis = given["axis"]
    u, v = (unit(letter) for letter in AXES[axis])
    n = unit(axis[1]) * (1.0 if axis[0] == "+" else -1.0)
    a, b = np.radians(given.get("tilt_deg", [0.0, 0.0]))
    plain = np.column_stack([u, v, n])
    about_u = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_v = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    return plain @ about_v @ about_u


def placed(given: dict[str, Any], across: float, up: float) -> Any:
    """Return the transform of Mitsuba's unit disk or rectangle."""
    matrix = np.eye(4)
    matrix[:3, :3] = frame(given) * [across, up, 1.0]
    matrix[:3, 3] = given["position"]
    return mi.ScalarTransform4f(matrix.tolist())


def grey(value: float) -> dict[str, Any]:
    return {"type": "spectrum", "value": value}


BLACK = {"type": "diffuse", "reflectance": grey(0.0)}


def lobe(scatter: dict[str, Any], delta: Any, square: Any, power: Any, exponential: Any) -> Any:
    """Return the BSDF in 1/sr at |β − β₀|, in numpy's or Dr.Jit's numbers."""
    if scatter["kind"] == "abg":
        return scatter["A"] / (scatter["B"] + power(delta, scatter["g"]))
    if scatter["kind"] == "harvey-shack":
        ratio = square(delta / scatter["L"])
        return scatter["b0"] * power(1.0 + ratio, 0.5 * scatter["S"])
    if scatter["kind"] == "gaussian":
        width = 2.0 * scatter["sigma"] ** 2
        return scatter["tis"] / (math.pi * width) * exponential(-square(delta) / width)
    raise KeyError(scatter["kind"])


def totals(scatter: dict[str, Any], sines: np.ndarray) -> np.ndarray:
    """Return the integral of BSDF × cosine over the hemisphere, by the midpoint rule.

    In direction cosines cos θ dω is the plain area of the unit disc.
    """
    n = 1500
    across = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    x, y = np.meshgrid(across, across[: n // 2])  # the other half is its mirror image
    inside = x * x + y * y < 1.0
    x, y = x[inside], y[inside]
    found = []
    for sine in sines:
        delta = np.hypot(x - sine, y)
        found.append(2.0 * lobe(scatter, delta, np.square, np.power, np.exp).sum() * (2.0 / n) ** 2)
    return np.array(found)


class Scattering(mi.BSDF):  # type: ignore[misc]
    """A mirror of which a part goes into a lobe about the mirrored ray, or the lobe alone."""

    def __init__(self, props: Any) -> None:
        mi.BSDF.__init__(self, props)
        self.law = json.loads(props["scatter"])
        self.reflectance = float(props["reflectance"])
        smooth = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
        sharp = mi.BSDFFlags.DeltaReflection | mi.BSDFFlags.FrontSide
        self.m_components = [smooth, sharp]
        self.m_flags = smooth | sharp
        sines = np.linspace(0.0, 1.0, 257)
        self.table = mi.Float(totals(self.law, sines).astype(np.float32))

    def total(self, sine: Any) -> Any:
        import drjit as dr

        at = dr.clip(sine, 0.0, 1.0) * 256.0
        low = mi.UInt32(dr.minimum(at, 255.0))
        part = at - mi.Float(low)
        return dr.lerp(
            dr.gather(mi.Float, self.table, low), dr.gather(mi.Float, self.table, low + 1), part
        )

    def density(self, wi: Any, wo: Any) -> Any:
        import drjit as dr

        delta = dr.sqrt(dr.square(wi.x + wo.x) + dr.square(wi.y + wo.y))
        return lobe(self.law, delta, dr.square, dr.power, dr.exp)

    def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> Any:
        import drjit as dr

        cosine = mi.Frame3f.cos_theta(si.wi)
        active = mi.Bool(active) & (cosine > 0.0)
        sharp = sample1 < (0.5 if self.reflectance > 0.0 else 0.0)
        wo = mi.warp.square_to_cosine_hemisphere(sample2)
        out = mi.BSDFSample3f()
        out.wo = dr.select(sharp, mi.reflect(si.wi), wo)
        chance = 0.5 if self.reflectance > 0.0 else 1.0
        out.pdf = dr.select(sharp, 0.5, chance * mi.warp.square_to_cosine_hemisphere_pdf(wo))
        out.eta = 1.0
        out.sampled_type = dr.select(
            sharp, mi.UInt32(+mi.BSDFFlags.DeltaReflection),
            mi.UInt32(+mi.BSDFFlags.GlossyReflection),
        )  # fmt: skip
        out.sampled_component = dr.select(sharp, mi.UInt32(1), mi.UInt32(0))
        sine = dr.safe_sqrt(1.0 - dr.square(cosine))
        mirrored = (self.reflectance - self.total(sine)) * 2.0
        spread = self.density(si.wi, wo) * math.pi / chance
        value = dr.select(sharp, mirrored, spread)
        return out, mi.Spectrum(value) & active

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        above, cosine = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active = mi.Bool(active) & (above > 0.0) & (cosine > 0.0)
        return mi.Spectrum(self.density(si.wi, wo) * cosine) & active

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        import drjit as dr

        above, cosine = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        chance = 0.5 if self.reflectance > 0.0 else 1.0
        found = chance * mi.warp.square_to_cosine_hemisphere_pdf(wo)
        return dr.select(mi.Bool(active) & (above > 0.0) & (cosine > 0.0), found, 0.0)

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def to_string(self) -> str:
        return "Scattering"


mi.register_bsdf("scattering", lambda props: Scattering(props))


def bsdf(surface: dict[str, Any], media: dict[str, Any]) -> dict[str, Any]:
    """Return what Mitsuba calls a surface; flat ones are black behind."""
    kind, scatter = surface["kind"], surface.get("scatter")
    if kind == "fresnel":
        return {
            "type": "dielectric",
            "int_ior": media[surface["medium"]]["index"],
            "ext_ior": media[surface.get("medium_outside", "vacuum")]["index"],
        }
    if scatter:
        share = surface["reflectance"] if kind == "mirror" else 0.0
        return {"type": "scattering", "scatter": json.dumps(scatter), "reflectance": share}
    if kind == "absorber":
        return BLACK
    if kind == "lambertian":
        return {"type": "diffuse", "reflectance": grey(surface["reflectance"])}
    if kind == "mirror":
        return {
            "type": "conductor", "material": "none",
            "specular_reflectance": grey(surface["reflectance"]),
        }  # fmt: skip
    raise KeyError(kind)


def inside(medium: dict[str, Any]) -> dict[str, Any] | None:
    if not medium.get("absorption_per_m"):
        return None
    return {"type": "homogeneous", "albedo": 0.0, "sigma_t": medium["absorption_per_m"]}


def translated(scene: dict[str, Any]) -> dict[str, Any]:
    """Return a scene in Mitsuba's terms."""
    media = {"vacuum": {"index": 1.0}} | {one["name"]: one for one in scene.get("medium", [])}
    (lamp,) = scene["source"]
    area = math.pi * lamp["radius"] ** 2
    out: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": LAYERS, "rr_depth": 64},
        "lamp": {
            "type": "disk", "to_world": placed(lamp, lamp["radius"], lamp["radius"]),
            "bsdf": {"type": "null"},
            "emitter": {"type": "area", "radiance": grey(lamp["flux"] / (math.pi * area))},
        },
    }  # fmt: skip
    for element in scene["element"]:
        kind, surface = element["kind"], element["surface"]
        shape: dict[str, Any] = {"bsdf": bsdf(surface, media)}
        if kind == "sphere":
            shape |= {
                "type": "sphere", "center": element["position"], "radius": element["radius"],
            }  # fmt: skip
        elif kind == "disk":
            radius = element["radius"]
            shape |= {"type": "disk", "to_world": placed(element, radius, radius)}
        else:
            half = element["half_width"], element["half_height"]
            shape |= {"type": "rectangle", "to_world": placed(element, *half)}
        if surface["kind"] == "fresnel":
            sides = {"interior": surface["medium"], "exterior": surface.get("medium_outside")}
            for side, name in sides.items():
                filled = inside(media[name]) if name else None
                if filled:
                    shape[side] = filled
        if element["name"] == "sensor":
            film = {
                "type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"},
                "pixel_format": "luminance",
            }  # fmt: skip
            sampler = {"type": "independent"}
            shape["sensor"] = {"type": "irradiancemeter", "film": film, "sampler": sampler}
        out[element["name"]] = shape
    return out


def main() -> None:
    """Answer with power and standard error, in watts."""
    samples, seed = map(int, sys.argv[1:])
    scene = json.load(sys.stdin)
    (sensor,) = (one for one in scene["element"] if one["name"] == "sensor")
    area = math.pi * sensor["radius"] ** 2
    loaded = mi.load_dict(translated(scene))
    found = []
    for group in range(GROUPS):
        seen = mi.render(loaded, spp=samples, seed=seed * GROUPS + group)
        found.append(area * float(np.array(seen).ravel()[0]))
    sigma = float(np.std(found, ddof=1)) / math.sqrt(GROUPS)
    print(
        json.dumps(
            {"tracer": f"Mitsuba {mi.__version__}", "value": float(np.mean(found)), "sigma": sigma}
        )
    )


if __name__ == "__main__":
    main()
