"""Scenes of the tests of reports."""

from __future__ import annotations

ABSORBER = {"kind": "absorber"}
HOSTILE = 'a<b> & "c" ${1+1}'
"""A name that is markup, an attribute's end and a template's expression where it is not escaped."""


def plate(name, z=0.0, axis="+z", **more):
    return {
        "name": name,
        "kind": "rectangle",
        "position": [0.0, 0.0, z],
        "axis": axis,
        "half_width": 1.0,
        "half_height": 1.0,
        "surface": ABSORBER,
        **more,
    }


def lamp(name="lamp", **more):
    place = {"position": [0.0, 0.0, 1.0], "axis": "-z"}
    return {"name": name, "kind": "cosine-point", "flux": 1.0, **place, **more}


def scene(name, **parts):
    return {"schema": "photizon/1", "name": name, "source": [lamp()], **parts}


def hostile():
    """Return a scene of two sources and a far field whose texts are all hostile."""
    return scene(
        HOSTILE,
        title="</title><script>throw 1</script><img src='http://example.invalid/x'>",
        notes="## no comment\n% for x in y:\n</style></details>",
        source=[lamp(HOSTILE), lamp("other", flux=0.5)],
        element=[
            plate(HOSTILE, detector={"map": [4, 4], "generations": 3}),
            plate("back", 2.0, "-z"),
        ],
        far_field={"n_mu": 8, "n_phi": 6},
    )


def capped():
    """Return a scene that splits, plays roulette, meets the cap, and has a dark detector."""
    return scene(
        "capped",
        element=[
            plate("glass", surface={"kind": "fresnel", "index": 1.5}),
            plate("mirror", -0.5, surface={"kind": "mirror", "reflectance": 0.9}),
            plate("behind", 2.0, "+z", detector={"generations": 40}),
        ],
        run={"generation_cap": 6, "roulette_floor": 0.1},
    )
