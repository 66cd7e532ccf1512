"""The arrays of a result with names, dimensions, coordinates and units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

    from photizon_cl.result.estimates import Estimates
    from photizon_cl.result.far_field import FarFieldResult
    from photizon_cl.result.ledger import Estimate
    from photizon_cl.result.maps import DetectorResult, IrradianceMap
    from photizon_cl.result.path_table import PathTable
    from photizon_cl.result.tallies import EffectTally

__all__ = ["dataset", "tree"]

_RESERVED: Final = frozenset({"far_field", "ledger"})
_MEAN: Final = "mean over batches"
_HATCHING: Final = "bins with a count below 10 have an unreliable sigma and are shown hatched"

Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, Any]]]


def _prefix(element: str, result: Estimates) -> str:
    """Return what the names of a detector's arrays begin with: the name of its element.

    An element named like one of the file's own prefixes gets a trailing underscore.
    """
    taken = _RESERVED.union(map(_tally_prefix, result.tallies))
    return f"{element}_" if element.rstrip("_") in taken else element


def _tally_prefix(effect: str) -> str:
    return f"tallies.{effect}"


def dataset(result: Estimates) -> xr.Dataset:
    """Return every array of a result, labelled.

    Variables are ``ledger.*``, ``DETECTOR.*``, ``far_field.*`` and ``tallies.EFFECT.*``; powers in
    W, irradiance in W/m², intensity in W/sr. A σ is NaN with a single batch.
    """
    import xarray as xr

    variables: Variables = {}
    coordinates: Variables = {}
    _ledger(result, variables, coordinates)
    for name, detector in result.detectors.items():
        at = _prefix(name, result)
        _detector(name, at, detector, variables, coordinates)
        if detector.power.by_wavelength:
            _by_wavelength(name, at, result, variables, coordinates)
    if result.far_field is not None:
        _far_field(result.far_field, variables, coordinates)
    for effect, cells in result.tallies.items():
        _tally(effect, cells, variables, coordinates)
    attrs = {
        "title": result.scene.title or result.scene.name,
        "scene_name": result.scene.name,
        "batches": result.batches,
        "rays_per_batch": result.scene.run.rays_per_batch,
        "tally_digest": result.tally_digest,
        "scene_digest": result.scene.digest(),
    }
    return xr.Dataset(variables, coordinates, attrs)


def tree(result: Estimates) -> xr.DataTree:
    """Return the arrays of `dataset` in groups, see `photizon_cl.Result.to_dataset`."""
    import xarray as xr

    flat = dataset(result)
    prefixes = {_tally_prefix(effect): f"tallies/{effect}" for effect in result.tallies}
    nodes: dict[str, tuple[Variables, Variables]] = {}
    for name, array in flat.variables.items():
        at, _, short = str(name).rpartition(".")
        variables, coordinates = nodes.setdefault(prefixes.get(at, at), ({}, {}))
        dims = tuple(str(dim).rpartition(".")[2] for dim in array.dims)
        into = coordinates if name in flat.coords else variables
        into[short] = (dims, array.values, dict(array.attrs))
    groups = {at: xr.Dataset(*parts) for at, parts in nodes.items()}
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=flat.attrs), **groups})


def _sigma(estimate: Estimate) -> float:
    return float("nan") if estimate.sigma is None else estimate.sigma


def _ledger(result: Estimates, variables: Variables, coordinates: Variables) -> None:
    ledger = result.ledger
    rows = ledger.labelled_rows()
    dim = ("ledger.row",)
    names = np.array([name for name, _ in rows], dtype=object)
    coordinates["ledger.row"] = (dim, names, {"long_name": "where the power ended"})
    values = [row.value for _, row in rows]
    variables["ledger.power"] = (
        dim,
        values,
        {"units": "W", "long_name": "power", "comment": _MEAN},
    )
    sigmas = [_sigma(row) for _, row in rows]
    variables["ledger.sigma"] = (dim, sigmas, {"units": "W", "long_name": "standard error"})
    closure = {"units": "W", "long_name": "closure", "comment": "emitted minus every other row"}
    variables["ledger.closure"] = ((), ledger.closure, closure)
    if ledger.emitted.by_wavelength:
        dims = (*_lines("ledger", result, variables, coordinates), *dim)
        of_rows = [row.by_wavelength for _, row in rows]
        power = {"units": "W", "long_name": "power", "comment": f"{_MEAN}, by wavelength"}
        parts = np.array([[part.value for part in row] for row in of_rows]).T
        variables["ledger.power_by_wavelength"] = (dims, parts, power)
        errors = np.array([[_sigma(part) for part in row] for row in of_rows]).T
        error = {"units": "W", "long_name": "standard error", "comment": "by wavelength"}
        variables["ledger.sigma_by_wavelength"] = (dims, errors, error)


def _lines(
    at: str, result: Estimates, variables: Variables, coordinates: Variables
) -> tuple[str, ...]:
    """Add the wavelengths as a coordinate; return its dimension."""
    spectrum = result.scene.spectrum
    assert spectrum is not None
    name = f"{at}.wavelength"
    about = {"units": "nm", "long_name": "wavelength", "comment": f"of the {spectrum.word}s"}
    coordinates[name] = ((name,), np.array(spectrum.middles_nm), about)
    if spectrum.edges_nm is not None:
        edges = {**about, "comment": "of the spectrum's bands", "bin": "edges"}
        variables[f"{name}_edges"] = ((f"{name}_edge",), np.array(spectrum.edges_nm), edges)
    return (name,)


def _by_wavelength(
    name: str, at: str, result: Estimates, variables: Variables, coordinates: Variables
) -> None:
    """Add what each line brings to a detector's power, ladder and map."""
    detector = result.detectors[name]
    dim = _lines(at, result, variables, coordinates)
    about = {"element": name, "comment": "by wavelength"}
    watts = {**about, "units": "W", "long_name": "power"}
    error = {**about, "units": "W", "long_name": "standard error"}
    count = {**about, "units": "1", "long_name": "arrivals"}
    parts = detector.power.by_wavelength
    end = "by_wavelength"
    variables[f"{at}.power_{end}"] = (dim, np.array([e.value for e in parts]), watts)
    variables[f"{at}.power_sigma_{end}"] = (dim, np.array([_sigma(e) for e in parts]), error)
    variables[f"{at}.power_count_{end}"] = (dim, np.array([e.count for e in parts]), count)
    if detector.ladder is not None:
        dims = (*dim, f"{at}.generation")
        of_rungs = [rung.by_wavelength for rung in detector.ladder]
        values = np.array([[e.value for e in row] for row in of_rungs]).T
        variables[f"{at}.ladder_{end}"] = (dims, values, watts)
        errors = np.array([[_sigma(e) for e in row] for row in of_rungs]).T
        variables[f"{at}.ladder_sigma_{end}"] = (dims, errors, error)
        counts = np.array([[e.count for e in row] for row in of_rungs]).T
        variables[f"{at}.ladder_count_{end}"] = (dims, counts, count)
    if detector.map is not None:
        maps, axes = detector.map.by_wavelength, detector.map.bins
        dims = (*dim, f"{at}.{axes.y.axis.name}", f"{at}.{axes.x.axis.name}")
        flux = {**about, "units": "W m-2"}
        value = {**flux, "long_name": "irradiance"}
        variables[f"{at}.irradiance_{end}"] = (dims, np.array([m.irradiance for m in maps]), value)
        spread = {**flux, "long_name": "standard error"}
        variables[f"{at}.sigma_{end}"] = (dims, np.array([m.sigma for m in maps]), spread)
        variables[f"{at}.count_{end}"] = (dims, np.array([m.count for m in maps]), count)


def _detector(
    name: str, at: str, detector: DetectorResult, variables: Variables, coordinates: Variables
) -> None:
    about = {"element": name}
    power = detector.power
    watts = {**about, "units": "W", "long_name": "power", "comment": _MEAN}
    error = {**about, "units": "W", "long_name": "standard error"}
    count = {**about, "units": "1", "long_name": "arrivals"}
    variables[f"{at}.power"] = ((), power.value, watts)
    variables[f"{at}.power_sigma"] = ((), _sigma(power), error)
    variables[f"{at}.power_count"] = ((), power.count, count)
    if detector.ladder is not None:
        dim = (f"{at}.generation",)
        text = "surface interactions before the arrival; the last entry collects all higher ones"
        rungs = detector.ladder
        generations = np.array([rung.generation for rung in rungs])
        label = {"units": "1", "long_name": "generation", "comment": text}
        coordinates[dim[0]] = (dim, generations, label)
        values = np.array([rung.value for rung in rungs])
        variables[f"{at}.ladder"] = (dim, values, watts)
        sigmas = np.array([_sigma_or_nan(rung.sigma) for rung in rungs])
        variables[f"{at}.ladder_sigma"] = (dim, sigmas, error)
        counts = np.array([rung.count for rung in rungs])
        variables[f"{at}.ladder_count"] = (dim, counts, count)
    if detector.map is not None:
        _map(at, about, detector.map, variables, coordinates)
    if detector.paths is not None:
        _paths(at, about, detector.paths, variables, coordinates)


def _sigma_or_nan(sigma: float | None) -> float:
    return float("nan") if sigma is None else sigma


def _axis(
    name: str,
    edges: Any,
    about: dict[str, str],
    variables: Variables,
    coordinates: Variables,
) -> str:
    """Add the centres of bins as a coordinate, and their edges; return the dimension."""
    attrs = about
    coordinates[name] = ((name,), 0.5 * (edges[:-1] + edges[1:]), {**attrs, "bin": "centre"})
    # A variable, since a coordinate off its own dimension may have no space in its name.
    variables[f"{name}_edges"] = ((f"{name}_edge",), edges, {**attrs, "bin": "edges"})
    return name


def _map(
    at: str, about: dict[str, str], m: IrradianceMap, variables: Variables, coordinates: Variables
) -> None:
    y, x = (
        _axis(
            f"{at}.{axis.name}",
            axis.edges,
            {"units": axis.units, "long_name": axis.symbol, "comment": axis.text},
            variables,
            coordinates,
        )
        for axis in (m.bins.y.axis, m.bins.x.axis)
    )
    dims = (y, x)
    text = "power over the exact area of the bin; NaN where it has none"
    flux = {**about, "units": "W m-2"}
    irradiance = {**flux, "long_name": "irradiance", "comment": text}
    variables[f"{at}.irradiance"] = (dims, m.irradiance, irradiance)
    error = {**flux, "long_name": "standard error", "comment": f"of the irradiance; {_HATCHING}"}
    variables[f"{at}.sigma"] = (dims, m.sigma, error)
    count = {**about, "units": "1", "long_name": "arrivals"}
    variables[f"{at}.count"] = (dims, m.count, count)
    area = {
        **about,
        "units": "m2",
        "long_name": "area",
        "comment": "exact, of the bin on the element",
    }
    variables[f"{at}.area"] = (dims, m.area, area)


def _paths(
    at: str, about: dict[str, str], table: PathTable, variables: Variables, coordinates: Variables
) -> None:
    dim = (f"{at}.path",)
    text = "faces and events in order: r reflected, t transmitted, i totally reflected, s scattered"
    names = np.array([row.sequence for row in table], dtype=object)
    coordinates[dim[0]] = (dim, names, {**about, "long_name": "path", "comment": text})
    power = {**about, "units": "W", "long_name": "power", "comment": _MEAN}
    error = {**about, "units": "W", "long_name": "standard error"}
    variables[f"{at}.path_power"] = (dim, np.array([row.power for row in table]), power)
    sigmas = np.array([_sigma_or_nan(row.sigma) for row in table])
    variables[f"{at}.path_sigma"] = (dim, sigmas, error)
    for name, words in (
        ("count", "arrivals"),
        ("interactions", "surface interactions before the arrival"),
        ("ghost_order", "reflections at refracting faces, -1 where not known"),
        ("example_ray", "number of the first ray that shows it"),
    ):
        found = [getattr(row, name) for row in table]
        numbers = np.array([-1 if one is None else one for one in found], np.int64)
        variables[f"{at}.path_{name}"] = (dim, numbers, {**about, "units": "1", "long_name": words})
    rest = table.rest
    left = {**power, "long_name": "power of all other paths"}
    variables[f"{at}.other_paths_power"] = ((), rest.power, left)
    variables[f"{at}.other_paths_sigma"] = ((), _sigma_or_nan(rest.sigma), error)


def _far_field(far: FarFieldResult, variables: Variables, coordinates: Variables) -> None:
    u, v, axis = far.axis_words
    if far.by_theta:
        about = {"units": "rad", "long_name": "θ", "comment": f"angle from {axis}"}
        row = _axis("far_field.theta", far.theta_edges, about, variables, coordinates)
    else:
        text = f"cosine of the angle from {axis}"
        about = {"units": "1", "long_name": "cos θ", "comment": text}
        row = _axis("far_field.mu", far.mu_edges, about, variables, coordinates)
    turn = f"azimuth from {u} towards {v.removeprefix('world ')}"
    about = {"units": "rad", "long_name": "φ", "comment": turn}
    phi = _axis("far_field.phi", far.phi_edges, about, variables, coordinates)
    dims = (row, phi)
    units = {"units": "W sr-1"}
    variables["far_field.intensity"] = (dims, far.intensity, {**units, "long_name": "intensity"})
    error = {**units, "long_name": "standard error", "comment": f"of the intensity; {_HATCHING}"}
    variables["far_field.sigma"] = (dims, far.sigma, error)
    variables["far_field.count"] = (dims, far.count, {"units": "1", "long_name": "rays"})
    solid = {"units": "sr", "long_name": "solid angle"}
    each = np.asarray(far.solid_angle)
    if each.ndim:
        solid["comment"] = "of a bin of each row"
        variables["far_field.solid_angle"] = ((row,), each[:, 0], solid)
    else:
        solid["comment"] = "of every bin"
        variables["far_field.solid_angle"] = ((), far.solid_angle, solid)


def _tally(effect: str, cells: EffectTally, variables: Variables, coordinates: Variables) -> None:
    """Add what an effect counts, shape (labels,)."""
    at = _tally_prefix(effect)
    dim = (f"{at}.label",)
    about = {"effect": effect}
    labels = np.array(list(cells), dtype=object)
    coordinates[dim[0]] = (dim, labels, {**about, "long_name": "what each cell is"})
    rows = cells.values()
    power = {**about, "units": cells.unit, "long_name": effect, "comment": _MEAN}
    variables[f"{at}.power"] = (dim, np.array([row.value for row in rows]), power)
    error = {**about, "units": cells.unit, "long_name": "standard error"}
    variables[f"{at}.sigma"] = (dim, np.array([_sigma(row) for row in rows]), error)
    count = {**about, "units": "1", "long_name": "count", "comment": "of all batches"}
    counts = np.array([row.count for row in rows], np.int64)
    variables[f"{at}.count"] = (dim, counts, count)
