"""A table of malformed scenes: what is changed in a good one, and every problem that this makes."""

import copy
import math

from photizon_cl.scene import registry

DELETE = object()
APPEND = object()

GOOD = {
    "schema": "photizon/1",
    "name": "good",
    "run": {"seed": 7},
    "far_field": {"n_mu": 10, "n_phi": 8},
    "source": [
        {"name": "lamp", "kind": "cosine-point", "flux": 1.0, "position": [0, 0, 1], "axis": "-z"},
        {
            "name": "ball", "kind": "lambertian-sphere", "flux": 2, "position": [0, 1, 1],
            "radius": 0.1,
        },
    ],
    "element": [
        {
            "name": "target", "kind": "rectangle", "position": [0.0, 0.0, 0.0], "axis": "+z",
            "half_width": 1.0, "half_height": 1.0,
            "surface": {"kind": "absorber"}, "detector": {"map": [4, 4], "generations": 3},
        },
        {
            "name": "plate", "kind": "disk", "position": [0, 0, 5.0], "axis": "-y", "radius": 0.5,
            "tilt_deg": [10, -20.5], "surface": {"kind": "lambertian", "reflectance": 0.5},
        },
        {
            "name": "lens", "kind": "sphere", "position": [3, 0, 0], "axis": "+x", "radius": 1.0,
            "surface": {"kind": "fresnel", "index": 1.5},
        },
    ],
}  # fmt: skip


def edited(changes):
    """Return the good scene with values set, deleted or appended at paths of keys."""
    tables = copy.deepcopy(GOOD)
    for path, value in changes:
        *parents, last = path
        place = tables
        for step in parents:
            place = place[step]
        if value is DELETE:
            del place[last]
        elif last is APPEND:
            place.append(value)
        else:
            place[last] = value
    return tables


S0, S1 = ("source", 0), ("source", 1)
E0, E1, E2 = ("element", 0), ("element", 1), ("element", 2)
LENGTH = "a positive length in metres, from 1e-150 to 1e150"
COORDINATE = "a coordinate in metres, from -1e150 to 1e150"
AXIS = 'one of "+x" "-x" "+y" "-y" "+z" "-z"'
NAME = "a name of 1 to 64 printable characters"
FRACTION = "a number in [0, 1]"
INDEX = "a refractive index, a number from 0.001 to 1000"
BINS = "an integer from 1 to 8192"
POWER = "a positive power in watts, from 1e-150 to 1e150"
KINDS = "one of " + " ".join(f'"{kind}"' for kind in registry.ELEMENTS)
SURFACES = "one of " + " ".join(f'"{kind}"' for kind in registry.SURFACES)
PORT = "0, or a number from 1e-16 up to but not including 1"


def one(name, keys, value, path, found, expected):
    return (name, [(keys, value)], [(path, found, expected)])


WHERE = {"name": "one", "position": [0, 0, 0], "axis": "+z", "surface": {"kind": "absorber"}}
CONIC = {
    **WHERE, "kind": "conic", "curvature_radius": 2.0, "conic_constant": -1.0,
    "aperture_radius": 1.0,
}  # fmt: skip
CONE = {**WHERE, "kind": "cone", "entrance_radius": 1.0, "exit_radius": 0.5, "length": 1.0}
CYLINDER = {**WHERE, "kind": "cylinder", "radius": 1.0, "length": 1.0}
CPC = {**WHERE, "kind": "cpc", "exit_radius": 1.0, "acceptance_deg": 0.01}
SHINES = {"name": "one", "flux": 1.0, "position": [0, 0, 0], "axis": "+z"}
CONE_POINT = {**SHINES, "kind": "cone-point", "half_angle_deg": 10.0}
SHINING = {**SHINES, "kind": "lambertian-rectangle", "half_width": 1.0, "half_height": 1.0}
BEAM = {**SHINES, "kind": "collimated-disk", "radius": 1.0}
HALF_ANGLE = "an angle from 1e-150 to 180 degrees"
DIVERGENCE = "an angle from 0 up to but not including 90 degrees"


def changed(table, key, value):
    return {k: v for k, v in {**table, key: value}.items() if v is not DELETE}


def kind(name, table, key, value, expected, path=None, found=None):
    """Return the case of an element of a kind with one value changed."""
    shown = found or ("nothing" if value is DELETE else str(value))
    return (name, [(E1, changed(table, key, value))],
            [(f"element[1].{path or key}", shown, expected)])  # fmt: skip


def lamp(name, table, key, value, expected):
    """Return the case of a source of a kind with one value changed."""
    shown = "nothing" if value is DELETE else str(value)
    return (name, [(S0, changed(table, key, value))], [(f"source[0].{key}", shown, expected)])


CASES = [
    # --- numbers -------------------------------------------------------------------------------
    one("negative radius", (*E1, "radius"), -0.5, "element[1].radius", "-0.5", LENGTH),
    one("zero length", (*E0, "half_width"), 0.0, "element[0].half_width", "0.0", LENGTH),
    one("zero integer length", (*E0, "half_width"), 0, "element[0].half_width", "0", LENGTH),
    one("negative zero", (*E0, "half_width"), -0.0, "element[0].half_width", "-0.0", LENGTH),
    one("nan length", (*E0, "half_height"), math.nan, "element[0].half_height", "nan", LENGTH),
    one("inf length", (*E0, "half_height"), math.inf, "element[0].half_height", "inf", LENGTH),
    one("huge length", (*E1, "radius"), 1e200, "element[1].radius", "1e+200", LENGTH),
    one("tiny length", (*E1, "radius"), 1e-200, "element[1].radius", "1e-200", LENGTH),
    one("giant integer", (*E1, "radius"), 10**400, "element[1].radius",
        "an integer of 1329 bits", LENGTH),
    one("bool length", (*E1, "radius"), True, "element[1].radius", "true", LENGTH),
    one("text length", (*E1, "radius"), "0.5", "element[1].radius", '"0.5"', LENGTH),
    one("list length", (*E1, "radius"), [0.5], "element[1].radius", "[0.5]", LENGTH),
    one("table length", (*E1, "radius"), {"m": 1}, "element[1].radius", "{m = 1}", LENGTH),
    one("source radius", (*S1, "radius"), -1, "source[1].radius", "-1", LENGTH),
    one("zero flux", (*S0, "flux"), 0, "source[0].flux", "0", POWER),
    one("negative flux", (*S0, "flux"), -1.0, "source[0].flux", "-1.0", POWER),
    one("nan flux", (*S0, "flux"), math.nan, "source[0].flux", "nan", POWER),
    one("bool flux", (*S0, "flux"), False, "source[0].flux", "false", POWER),
    # --- vectors -------------------------------------------------------------------------------
    one("inf position", (*S0, "position", 1), math.inf, "source[0].position[1]", "inf", COORDINATE),
    one("nan position", (*E0, "position", 2), math.nan, "element[0].position[2]", "nan",
        COORDINATE),
    one("huge position", (*E0, "position", 0), -1e151, "element[0].position[0]", "-1e+151",
        COORDINATE),
    one("bool position", (*E0, "position", 0), True, "element[0].position[0]", "true", COORDINATE),
    one("short position", (*E0, "position"), [0, 0], "element[0].position", "[0, 0]",
        "three coordinates [x, y, z] in metres"),
    one("long position", (*S0, "position"), [0, 0, 0, 0], "source[0].position", "[0, 0, 0, 0]",
        "three coordinates [x, y, z] in metres"),
    one("scalar position", (*S0, "position"), 1.0, "source[0].position", "1.0",
        "three coordinates [x, y, z] in metres"),
    one("text position", (*S0, "position"), "0 0 1", "source[0].position", '"0 0 1"',
        "three coordinates [x, y, z] in metres"),
    one("nan tilt", (*E1, "tilt_deg", 0), math.nan, "element[1].tilt_deg[0]", "nan",
        "an angle in degrees, from -360 to 360"),
    one("huge tilt", (*E1, "tilt_deg", 1), 1e9, "element[1].tilt_deg[1]", "1000000000.0",
        "an angle in degrees, from -360 to 360"),
    one("one tilt", (*E1, "tilt_deg"), [1.0], "element[1].tilt_deg", "[1.0]",
        "two angles [a, b] in degrees"),
    # --- words ---------------------------------------------------------------------------------
    one("bad axis", (*E0, "axis"), "z", "element[0].axis", '"z"', AXIS),
    one("vector axis", (*S0, "axis"), [0, 0, 1], "source[0].axis", "[0, 0, 1]", AXIS),
    one("number axis", (*S0, "axis"), 1, "source[0].axis", "1", AXIS),
    one("empty name", (*E0, "name"), "", "element[0].name", '""', NAME),
    one("number name", (*E0, "name"), 3, "element[0].name", "3", NAME),
    one("control in name", (*S0, "name"), "a\x07b", "source[0].name", '"a\\u0007b"', NAME),
    one("long name", (*E0, "name"), "n" * 65, "element[0].name", '"' + "n" * 58 + "…", NAME),
    one("slash in name", (*E0, "name"), "a/b", "element[0].name", '"a/b"', NAME),
    one("space around name", (*E0, "name"), " a", "element[0].name", '" a"', NAME),
    one("scene name", ("name",), "", "name", '""', NAME),
    one("title", ("title",), 5, "title", "5", "text"),
    one("control in notes", ("notes",), "a\x1b[0m", "notes", '"a\\u001b[0m"', "text"),
    # --- surfaces ------------------------------------------------------------------------------
    one("reflectance -0.1", (*E1, "surface", "reflectance"), -0.1,
        "element[1].surface.reflectance", "-0.1", FRACTION),
    one("reflectance 1.0000001", (*E1, "surface", "reflectance"), 1.0000001,
        "element[1].surface.reflectance", "1.0000001", FRACTION),
    one("reflectance nan", (*E1, "surface", "reflectance"), math.nan,
        "element[1].surface.reflectance", "nan", FRACTION),
    one("reflectance missing", (*E1, "surface", "reflectance"), DELETE,
        "element[1].surface.reflectance", "nothing", FRACTION),
    one("index zero", (*E2, "surface", "index"), 0, "element[2].surface.index", "0", INDEX),
    one("index negative", (*E2, "surface", "index_outside"), -1.0,
        "element[2].surface.index_outside", "-1.0", INDEX),
    one("index huge", (*E2, "surface", "index"), 1001, "element[2].surface.index", "1001", INDEX),
    one("surface kind", (*E1, "surface", "kind"), "lambertion",
        "element[1].surface.kind", '"lambertion"', SURFACES),
    one("surface without kind", (*E0, "surface"), {}, "element[0].surface.kind", "nothing",
        SURFACES),
    one("surface as text", (*E0, "surface"), "absorber", "element[0].surface", '"absorber"',
        "a table for the surface"),
    one("surface as list", (*E0, "surface"), [], "element[0].surface", "[]",
        "a table for the surface"),
    one("surface missing", (*E1, "surface"), DELETE, "element[1].surface", "nothing", "a surface"),
    one("key of another surface", (*E0, "surface", "reflectance"), 0.5,
        "element[0].surface.reflectance", "0.5", "no such key; the surface absorber takes kind"),
    # --- elements ------------------------------------------------------------------------------
    one("element kind", (*E0, "kind"), "plane", "element[0].kind", '"plane"', KINDS),
    one("element kind of a source", (*E0, "kind"), "isotropic-point", "element[0].kind",
        '"isotropic-point"', KINDS),
    one("element kind number", (*E0, "kind"), 4, "element[0].kind", "4", KINDS),
    one("element kind list", (*E0, "kind"), ["disk"], "element[0].kind", '["disk"]', KINDS),
    one("element without kind", (*E0, "kind"), DELETE, "element[0].kind", "nothing", KINDS),
    one("element without axis", (*E0, "axis"), DELETE, "element[0].axis", "nothing", AXIS),
    one("element without name", (*E0, "name"), DELETE, "element[0].name", "nothing", NAME),
    one("element without size", (*E0, "half_width"), DELETE, "element[0].half_width", "nothing",
        LENGTH),
    one("element is a number", ("element", APPEND), 3, "element[3]", "3",
        "a table for the element"),
    one("unknown element key", (*E0, "colour"), "red", "element[0].colour", '"red"',
        "no such key; the element rectangle takes kind, name, position"),
    one("unknown quoted key", (*E0, "half width"), 1, 'element[0]."half width"', "1",
        "no such key; the element rectangle takes"),
    one("duplicate element", (*E2, "name"), "target", "element[2].name", '"target"',
        "a name that no other element has"),
    one("duplicate source", (*S1, "name"), "lamp", "source[1].name", '"lamp"',
        "a name that no other source has"),
    one("port_fraction 1.2", (*E2, "port_fraction"), 1.2, "element[2].port_fraction", "1.2", PORT),
    one("port_fraction 1", (*E2, "port_fraction"), 1, "element[2].port_fraction", "1", PORT),
    one("port_fraction -0.1", (*E2, "port_fraction"), -0.1, "element[2].port_fraction", "-0.1",
        PORT),
    one("port_fraction unseen", (*E2, "port_fraction"), 1e-17, "element[2].port_fraction", "1e-17",
        PORT),
    one("fresnel wall", (*E2, "port_fraction"), 0.05, "element[2].surface.kind", '"fresnel"',
        "a surface that does not refract"),
    # --- round elements, mixed surfaces, shaped sources ----------------------------------------
    kind("negative curvature", CONIC, "curvature_radius", -1.0, LENGTH),
    kind("conic without aperture", CONIC, "aperture_radius", DELETE, LENGTH),
    kind("conic constant", CONIC, "conic_constant", 1e7, "a number from -1e6 to 1e6"),
    kind("conic constant nan", CONIC, "conic_constant", math.nan, "a number from -1e6 to 1e6"),
    kind("hole as wide as the sheet", CONIC, "inner_radius", 1.0, "less than aperture_radius, 1.0"),
    kind("negative hole", CONIC, "inner_radius", -0.1,
         "a radius from 0 up to but not including aperture_radius, in metres"),
    kind("beyond the equator", {**CONIC, "conic_constant": 3.0}, "aperture_radius", 1.5,
         "at most R/sqrt(1 + k), 1.0"),
    kind("sag out of range", {**CONIC, "curvature_radius": 1e-150}, "aperture_radius", 1e100,
         "an aperture of a sheet at most 1e+150 m high"),
    kind("map on a conic", CONIC, "detector", {"map": [2, 2]}, "no map on a conic",
         path="detector.map", found="[2, 2]"),
    kind("negative entrance", CONE, "entrance_radius", -1, "a radius from 0 to 1e150 in metres"),
    kind("cone of no width", {**CONE, "entrance_radius": 0.0}, "exit_radius", 0.0,
         "a positive radius"),
    kind("cone of no length", CONE, "length", 0, LENGTH),
    kind("cone too flat", {**CONE, "exit_radius": 1e10}, "length", 1e-140,
         "at least |r1 - r0| max(r0, r1)/1e+150 m, about 1.00e-130"),
    kind("cone of glass", CONE, "surface", {"kind": "fresnel", "index": 1.5},
         "a surface that does not refract", path="surface.kind", found='"fresnel"'),
    kind("cylinder of no radius", CYLINDER, "radius", 0.0, LENGTH),
    kind("cylinder without length", CYLINDER, "length", DELETE, LENGTH),
    kind("front of a cylinder", CYLINDER, "detector", {"side": "front"},
         'one of "inside" "outside"', path="detector.side", found='"front"'),
    kind("cpc out of range", CPC, "exit_radius", 1e149, "an exit whose CPC is at most 1e+150 m"),
    one("hole as wide as the disk", (*E1, "inner_radius"), 0.5, "element[1].inner_radius", "0.5",
        "less than radius, 0.5"),
    one("text hole", (*E1, "inner_radius"), "0.1", "element[1].inner_radius", '"0.1"',
        "a radius from 0 up to but not including radius, in metres"),
    one("more than arrives", (*E1, "surface"), {"kind": "mixed", "specular": 0.6, "diffuse": 0.5},
        "element[1].surface.diffuse", "0.5", "at most 1 - 0.6"),
    one("negative specular", (*E1, "surface"), {"kind": "mixed", "specular": -1, "diffuse": 0.5},
        "element[1].surface.specular", "-1", FRACTION),
    one("mixed without diffuse", (*E1, "surface"), {"kind": "mixed", "specular": 0.5},
        "element[1].surface.diffuse", "nothing", FRACTION),
    lamp("no half-angle", CONE_POINT, "half_angle_deg", DELETE, HALF_ANGLE),
    lamp("half-angle 0", CONE_POINT, "half_angle_deg", 0.0, HALF_ANGLE),
    lamp("half-angle 181", CONE_POINT, "half_angle_deg", 181, HALF_ANGLE),
    lamp("half-angle whose cone vanishes", CONE_POINT, "half_angle_deg", 1e-300, HALF_ANGLE),
    lamp("flat rectangle", SHINING, "half_height", 0, LENGTH),
    lamp("no width", SHINING, "half_width", DELETE, LENGTH),
    lamp("radius of a rectangle", SHINING, "radius", 0.5,
         "no such key; the source lambertian-rectangle takes"),
    lamp("divergence 90", BEAM, "divergence_deg", 90.0, DIVERGENCE),
    lamp("divergence -1", BEAM, "divergence_deg", -1, DIVERGENCE),
    lamp("divergence nan", BEAM, "divergence_deg", math.nan, DIVERGENCE),
    # --- detectors -----------------------------------------------------------------------------
    one("detector on lambertian", (*E1, "detector"), {}, "element[1].detector", "{}",
        "no detector on a lambertian surface"),
    one("detector on mirror", (*E0, "surface"), {"kind": "mirror", "reflectance": 1},
        "element[0].detector", "{map = [4, 4], generations = 3}",
        "no detector on a mirror surface"),
    one("detector on glass", (*E2, "detector"), {"side": "outside"}, "element[2].detector",
        '{side = "outside"}', "no detector on a fresnel surface"),
    one("side on flat", (*E0, "detector", "side"), "inside", "element[0].detector.side",
        '"inside"', 'one of "front" "back"'),
    one("bad side", (*E0, "detector", "side"), "top", "element[0].detector.side", '"top"',
        'one of "front" "back" "inside" "outside"'),
    one("map of zero", (*E0, "detector", "map", 0), 0, "element[0].detector.map[0]", "0", BINS),
    one("map too fine", (*E0, "detector", "map", 1), 8193, "element[0].detector.map[1]", "8193",
        BINS),
    one("map of floats", (*E0, "detector", "map", 1), 4.0, "element[0].detector.map[1]", "4.0",
        BINS),
    one("map of one", (*E0, "detector", "map"), [4], "element[0].detector.map", "[4]",
        "two integers [nx, ny], each from 1 to 8192"),
    one("map as number", (*E0, "detector", "map"), 32, "element[0].detector.map", "32",
        "two integers [nx, ny], each from 1 to 8192"),
    one("no generations", (*E0, "detector", "generations"), 0,
        "element[0].detector.generations", "0", "an integer from 1 to 4096"),
    one("bool generations", (*E0, "detector", "generations"), True,
        "element[0].detector.generations", "true", "an integer from 1 to 4096"),
    one("detector as bool", (*E0, "detector"), True, "element[0].detector", "true",
        "a table for the detector"),
    one("detector key", (*E0, "detector", "bins"), 3, "element[0].detector.bins", "3",
        "no such key; the detector table takes map, generations, paths, wavelengths, "
        "side"),
    # --- sources -------------------------------------------------------------------------------
    one("source kind", (*S0, "kind"), "laser", "source[0].kind", '"laser"',
        'one of "isotropic-point" "cosine-point" "lambertian-disk" "lambertian-sphere"'),
    one("axis on a point", (*S0, "kind"), "isotropic-point", "source[0].axis", '"-z"',
        "no such key; the source isotropic-point takes kind, name, flux, position, share"),
    one("share in one", (*S0, "share"), 1.0, "source[1].share", "nothing", "a share"),
    one("source missing", ("source",), DELETE, "source", "nothing",
        "at least one [[source]] table"),
    one("source empty", ("source",), [], "source", "an empty array",
        "at least one [[source]] table"),
    one("source single", ("source",), GOOD["source"][0], "source", "a single table",
        "an array of [[source]] tables"),
    one("element single", ("element",), {"name": "a"}, "element", "a single table",
        "an array of [[element]] tables"),
    one("element as text", ("element",), "box", "element", '"box"',
        "an array of [[element]] tables"),
    # --- top level, run, far field -------------------------------------------------------------
    one("no schema", ("schema",), DELETE, "schema", "nothing", '"photizon/1"'),
    one("other schema", ("schema",), "photizon/2", "schema", '"photizon/2"', '"photizon/1"'),
    one("number schema", ("schema",), 1, "schema", "1", '"photizon/1"'),
    one("no name", ("name",), DELETE, "name", "nothing", NAME),
    one("unknown top key", ("units",), "mm", "units", '"mm"', "no such key; a scene file takes"),
    one("run as number", ("run",), 5, "run", "5", "a table for the run"),
    one("seed -1", ("run", "seed"), -1, "run.seed", "-1", "an integer from 0 to 2^64 - 1"),
    one("seed float", ("run", "seed"), 1.5, "run.seed", "1.5", "an integer from 0 to 2^64 - 1"),
    one("seed text", ("run", "seed"), "1", "run.seed", '"1"', "an integer from 0 to 2^64 - 1"),
    one("seed 2^64", ("run", "seed"), 2**64, "run.seed", str(2**64),
        "an integer from 0 to 2^64 - 1"),
    one("no rays", ("run", "rays_per_batch"), 0, "run.rays_per_batch", "0",
        "an integer from 1 to 16777216"),
    one("sigma 0", ("run", "target_sigma"), 0, "run.target_sigma", "0", "a number in (0, 1]"),
    one("sigma 5", ("run", "target_sigma"), 5, "run.target_sigma", "5", "a number in (0, 1]"),
    one("no time", ("run", "max_seconds"), -60, "run.max_seconds", "-60",
        "a positive time in seconds, up to 1e9"),
    one("endless time", ("run", "max_seconds"), math.inf, "run.max_seconds", "inf",
        "a positive time in seconds, up to 1e9"),
    one("cap 0", ("run", "generation_cap"), 0, "run.generation_cap", "0",
        "an integer from 1 to 1048575"),
    one("cap too high", ("run", "generation_cap"), 2**20, "run.generation_cap", "1048576",
        "an integer from 1 to 1048575"),
    one("floor 2", ("run", "roulette_floor"), 2.0, "run.roulette_floor", "2.0", FRACTION),
    one("unknown run key", ("run", "batches"), 3, "run.batches", "3",
        "no such key; the run table takes seed, rays_per_batch"),
    one("far field bool", ("far_field",), True, "far_field", "true", "a table for the far_field"),
    one("far field bins", ("far_field", "n_mu"), 0, "far_field.n_mu", "0", BINS),
    one("far field key", ("far_field", "n_rho"), 9, "far_field.n_rho", "9",
        "no such key; the far_field table takes axis, tilt_deg, n_mu, n_theta, theta_edges_deg"),
    one("far field axis", ("far_field", "axis"), "z", "far_field.axis", '"z"', 'one of "+x" "-x"'),
    one("far field rows twice", ("far_field", "n_theta"), 9, "far_field.n_theta", "9",
        "nothing beside n_mu"),
    one("far field edges beside rows", ("far_field", "theta_edges_deg"), [0, 9],
        "far_field.theta_edges_deg", "[0.0, 9.0]", "nothing beside n_mu"),
    one("far field edge alone", ("far_field",), {"theta_edges_deg": [9]},
        "far_field.theta_edges_deg", "1 number", "2 to 8193 ascending angles in degrees"),
    one("far field edges number", ("far_field",), {"theta_edges_deg": 9},
        "far_field.theta_edges_deg", "9", "2 to 8193 ascending angles in degrees"),
    one("far field edge behind", ("far_field",), {"theta_edges_deg": [0, 90, 180.5]},
        "far_field.theta_edges_deg[2]", "180.5", "a number from 0 to 180"),
    one("far field edge before", ("far_field",), {"theta_edges_deg": [-1, 90]},
        "far_field.theta_edges_deg[0]", "-1", "a number from 0 to 180"),
    one("far field edge text", ("far_field",), {"theta_edges_deg": [0, "a"]},
        "far_field.theta_edges_deg[1]", '"a"', "a number from 0 to 180"),
    one("far field edges back", ("far_field",), {"theta_edges_deg": [0, 20, 10, 5]},
        "far_field.theta_edges_deg[2]", "10.0", "a number above 20.0, which stands before it"),
    one("far field edge twice", ("far_field",), {"theta_edges_deg": [0, 20, 20]},
        "far_field.theta_edges_deg[2]", "20.0", "a number above 20.0"),
    one("far field edges close", ("far_field",), {"theta_edges_deg": [0, 20, 20 + 5e-10]},
        "far_field.theta_edges_deg[2]", "20.0000000005", "a number above 20.0"),
    one("far field too many edges", ("far_field",), {"theta_edges_deg": [*range(8194)]},
        "far_field.theta_edges_deg", "8194 numbers", "2 to 8193 ascending"),
    one("far field bins in theta", ("far_field",), {"n_theta": 0}, "far_field.n_theta", "0", BINS),
    # --- several at once -----------------------------------------------------------------------
    ("mistyped required key is one problem",
     [((*E1, "radius"), DELETE), ((*E1, "raduis"), 1.0)],
     [("element[1].raduis", "1.0", "no such key; the element disk takes")]),
    ("two coordinates",
     [((*E0, "position"), [math.nan, 0, "1"])],
     [("element[0].position[0]", "nan", COORDINATE),
      ("element[0].position[2]", '"1"', COORDINATE)]),
    ("unknown kind hides no common mistake",
     [((*E0, "kind"), "plane"), ((*E0, "axis"), "up"), ((*E0, "surface", "kind"), "glass")],
     [("element[0].kind", '"plane"', KINDS), ("element[0].axis", '"up"', AXIS),
      ("element[0].surface.kind", '"glass"', SURFACES)]),
    ("a bad surface hides no bad detector",
     [((*E1, "surface", "reflectance"), 2), ((*E1, "detector"), {"generations": -1})],
     [("element[1].surface.reflectance", "2", FRACTION),
      ("element[1].detector.generations", "-1", "an integer from 1 to 4096"),
      ("element[1].detector", "{}", "no detector on a lambertian surface")]),
    ("shares",
     [((*S0, "share"), 0), ((*S1, "share"), -2.0)],
     [("source[0].share", "0", "a positive number, from 1e-150 to 1e150"),
      ("source[1].share", "-2.0", "a positive number, from 1e-150 to 1e150")]),
    ("all over the file",
     [(("schema",), "v1"), (("run", "seed"), -1), (("far_field", "n_phi"), 0.5),
      ((*S0, "flux"), "1 W"), ((*E0, "half_width"), -1), ((*E0, "detector", "map"), [0, 9000]),
      ((*E2, "port_fraction"), 0.5), ((*E2, "name"), "plate"), (("colour",), 1)],
     [("schema", '"v1"', '"photizon/1"'),
      ("colour", "1", "no such key"),
      ("source[0].flux", '"1 W"', POWER),
      ("element[0].detector.map[0]", "0", BINS),
      ("element[0].detector.map[1]", "9000", BINS),
      ("element[0].half_width", "-1", LENGTH),
      ("element[2].surface.kind", '"fresnel"', "a surface that does not refract"),
      ("run.seed", "-1", "an integer from 0 to 2^64 - 1"),
      ("far_field.n_phi", "0.5", BINS),
      ("element[2].name", '"plate"', "a name that no other element has")]),
]  # fmt: skip
