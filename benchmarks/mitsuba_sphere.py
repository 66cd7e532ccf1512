"""The patch of an integrating sphere by Mitsuba's path tracer, for `benchmarks.importance`.

A program of its own, for an interpreter that has `mitsuba` and `numpy` from PyPI; its LLVM variants
need a libLLVM, which ``DRJIT_LIBLLVM_PATH`` names (Debian's package ``libllvm19`` has one). Answers
every line of its standard input, a number of samples and a seed, with seconds and the power on the
patch in watts.

Paths begin at the patch, on its one side (an ``irradiancemeter``), and connect to the lamp at every
bounce. The lamp is a point, which such a path cannot meet: what comes straight from the lamp to the
patch is not part of the answer.
"""

from __future__ import annotations

import json
import math
import sys
import time


def main() -> None:
    """Answer until the input ends."""
    import mitsuba as mi
    import numpy as np

    mi.set_variant("llvm_ad_mono")
    reflectance, depth, roulette = float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    area = 0.01 * 4.0 * math.pi
    radius = math.sqrt(area / math.pi)
    height = -math.sqrt(1.0 - radius * radius)
    grey = {"type": "spectrum", "value": reflectance}
    film = {
        "type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"},
        "pixel_format": "luminance",
    }  # fmt: skip
    transform = mi.ScalarTransform4f().translate([0, 0, height]).scale([radius, radius, 1])
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth, "rr_depth": roulette},
            "wall": {
                "type": "sphere", "radius": 1.0, "flip_normals": True,
                "bsdf": {"type": "diffuse", "reflectance": grey},
            },
            "lamp": {
                "type": "point", "position": [0.3, 0.2, 0.1],
                "intensity": {"type": "spectrum", "value": 1.0 / (4.0 * math.pi)},
            },
            "patch": {
                "type": "disk", "to_world": transform,
                "bsdf": {"type": "diffuse", "reflectance": {"type": "spectrum", "value": 0.0}},
                "sensor": {
                    "type": "irradiancemeter", "film": film, "sampler": {"type": "independent"},
                },
            },
        }
    )  # fmt: skip
    print(json.dumps({"mitsuba": mi.__version__, "variant": mi.variant()}), flush=True)
    for line in sys.stdin:
        samples, seed = map(int, line.split())
        started = time.perf_counter()
        irradiance = float(np.array(mi.render(scene, spp=samples, seed=seed)).ravel()[0])
        took = time.perf_counter() - started
        print(json.dumps({"seconds": took, "power": irradiance * area}), flush=True)


if __name__ == "__main__":
    main()
