"""What once overflowed in silence: a row, a code, a parameter taken for another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest
from oracles.engine import compiled, scene_of, trace_compiled
from oracles.scenes import BLACK, beam, matt, mirror, wall

import photizon_cl as pz
from hostcode.errors import HostError
from hostcode.program.codes import CODE, decode, encode
from photizon_cl.compile.compiled import compile_scene
from photizon_cl.errors import ArgumentError
from photizon_cl.scene import registry
from photizon_cl.scene.elements.base import Element
from photizon_cl.scene.rows import Row

# a program or more a test, for few rays
pytestmark = pytest.mark.usefixtures("built_quickly")


def room() -> pz.Scene:
    """A matt and a shining wall, and a black one with a map."""
    counted = {**wall((0, 0, -1), "+z"), **BLACK, "detector": {"map": [4, 4]}, "tilt_deg": [1, 2]}
    lamp = {"kind": "cosine-point", "flux": 1.0, "position": [0, 0, 0], "axis": "+z"}
    elements = [{**wall((0, 0, 1), "-z"), **matt(0.5)}, {**wall((1, 0, 0), "-x"), **mirror(0.25)}]
    return scene_of([lamp], [*elements, counted])


@dataclass(frozen=True)
class FiveNumbers(pz.Lambertian):
    """A surface with more columns than the four that rows once had."""

    row: ClassVar[Row] = Row(
        "LAMBERTIAN",
        *((name, "", "unused") for name in ("a", "b", "c", "d")),
        ("reflectance", "", "part of the weight that goes on"),
    )

    def packed(self) -> dict[str, float]:
        return {**dict.fromkeys("abcd", 7.0), "reflectance": self.reflectance}


def test_a_surface_of_five_numbers_moves_no_other_material():
    plain = room()
    first = replace(plain.element[0], surface=FiveNumbers(0.5))
    wide = replace(plain, element=(first, *plain.element[1:]))
    made = compiled(wide, rays_per_batch=512)
    assert made.tables.spec.strides.material == 5
    assert made.tables.materials.reshape(-1, 5)[:, -1].tolist()[0] == 0.5
    assert len({tuple(row) for row in made.tables.materials.reshape(-1, 5)}) == 3
    assert trace_compiled(made).digest == trace_compiled(compiled(plain, rays_per_batch=512)).digest


@dataclass(frozen=True, kw_only=True)
class ManyNumbers(pz.Rectangle):
    """An element with more columns than the twelve that rows once had."""

    row: ClassVar[Row] = Row(
        "MANY", *((f"n{n}", "", "unused") for n in range(20)), base=pz.Rectangle.row
    )

    def packed(self, *where: Any) -> dict[str, float]:
        return {**super().packed(*where), **{f"n{n}": 7.0 for n in range(20)}}


def test_an_element_of_many_numbers_keeps_its_frame():
    plain = room()
    old = plain.element[2]
    sizes = {"half_width": old.half_width, "half_height": old.half_height}
    many = ManyNumbers(
        name=old.name, position=old.position, axis=old.axis, tilt_deg=old.tilt_deg,
        surface=old.surface, detector=old.detector, **sizes,
    )  # fmt: skip
    made = compiled(replace(plain, element=(*plain.element[:2], many)), rays_per_batch=512)
    strides = made.tables.spec.strides
    assert strides.row_frame == 3 + 12 + 20
    assert strides.row >= strides.row_frame + 9
    rows = made.tables.geometry.reshape(-1, strides.row)
    assert (rows[2, strides.row_frame :][:9] == np.ravel(old.frame)).all()
    assert trace_compiled(made).digest == trace_compiled(compiled(plain, rays_per_batch=512)).digest


@dataclass(frozen=True, kw_only=True)
class Narrow(pz.CosinePoint):
    """A point source with a parameter that is no radius."""

    row: ClassVar[Row] = Row("COSINE_POINT", ("power", "", "exponent of its lobe"))

    def packed(self) -> dict[str, float]:
        return {"power": 1e6}


def test_a_parameter_of_a_source_is_not_taken_for_a_radius():
    plain = room()
    lamp = plain.source[0]
    narrow = Narrow(name=lamp.name, flux=1.0, position=lamp.position, axis=lamp.axis)
    scene = replace(plain, source=(narrow,))
    made = compiled(scene, rays_per_batch=512)
    assert narrow.reach == 0.0
    assert made.shift == compiled(plain).shift
    assert not made.tables.spec.sources[0].draws_position
    assert made.effects == compiled(plain).effects
    assert trace_compiled(made).digest == trace_compiled(compiled(plain, rays_per_batch=512)).digest


def test_the_bits_of_a_code_do_not_overlap():
    taken = 0
    for field in CODE.values():
        bits = field.mask << field.shift
        assert not taken & bits
        taken |= bits
        assert decode(encode(**{field.name: field.mask}), field.name) == field.mask
    assert taken < 2**61  # two bits more in what a ray has left, and the sign
    highest = encode(**{name: field.mask for name, field in CODE.items()})
    assert all(decode(highest, name) == field.mask for name, field in CODE.items())


@pytest.mark.parametrize("name", CODE)
def test_what_a_code_cannot_hold_is_refused(name):
    with pytest.raises(HostError, match="cannot tell them apart"):
        encode(**{name: CODE[name].limit})


def surface_kind(number: int) -> type[pz.Lambertian]:
    return type(f"Kind{number}", (pz.Lambertian,), {"kernel": f"kind_{number:03d}"})


def many_kinds(n: int) -> pz.Scene:
    """A scene of n surface kinds; the last one has the detector beside it."""
    plain = room()
    base = plain.element[0]
    walls = [
        replace(base, name=f"wall {k}", position=(0.0, 0.0, 2.0 + k), surface=surface_kind(k)(0.5))
        for k in range(n - 1)
    ]
    return replace(plain, element=(*walls, plain.element[2]))


def test_the_17th_surface_kind_is_no_detector():
    made = compiled(many_kinds(17))
    codes = [int(c) for c in made.tables.codes if c >> 32 < 17 and c > 1 << 8][:40]
    with_detector = {decode(c, "element") for c in codes if decode(c, "detector")}
    assert with_detector <= {16}
    numbers = [s.number for s in made.tables.spec.surfaces]
    assert numbers == list(range(17))


def test_more_surface_kinds_than_a_code_tells_apart_are_refused():
    limit = CODE["surface"].limit
    assert compiled(many_kinds(limit)).tables.spec.surfaces[-1].number == limit - 1
    with pytest.raises(ArgumentError, match=f"more than {limit} surface kinds"):
        compiled(many_kinds(limit + 1))


def test_an_element_without_bins_of_its_own_has_no_map():
    class Bare(pz.Sphere):
        """An element that says that it has a map and does not say how it is binned."""

        map_bins = Element.map_bins

    ball = {"kind": "sphere", "position": [0, 0, 0], "axis": "+z", "radius": 1.0, **BLACK}
    whole = scene_of([beam((0, 0, 0), "+z")], [{**ball, "detector": {"map": [2, 2]}}]).element[0]
    bare = Bare(
        name="bare", position=whole.position, axis=whole.axis, surface=whole.surface,
        detector=whole.detector, radius=1.0,
    )  # fmt: skip
    scene = replace(room(), element=(bare,))
    with pytest.raises(NotImplementedError, match="no map on a sphere"):
        compile_scene(scene, scene.run)


def test_a_row_takes_its_columns_and_no_others():
    row = Row("TEST", ("a", "m", ""), ("b", "", ""))
    assert row.pack({"b": 2.0, "a": 1.0}) == [1.0, 2.0]
    assert Row("MORE", ("c", "", ""), base=row).constants(3) == {
        "TEST_A": 3, "TEST_B": 4, "MORE_C": 5,
    }  # fmt: skip
    for wrong in ({"a": 1.0}, {"a": 1.0, "c": 2.0}, {"a": 1.0, "b": 2.0, "c": 3.0}):
        with pytest.raises(ValueError, match="row TEST"):
            row.pack(wrong)
    with pytest.raises(ValueError, match="used twice"):
        Row("TWICE", ("a", "", ""), ("a", "", ""))


def test_no_kernel_holds_a_literal_column():
    import re

    from hostcode.assets import kernels_dir

    literal = re.compile(r"\b(row|source|table)\[\d+\]|geometry \+ \d|materials? \+ \d|, only, \d")
    for folder in ("elements", "surfaces", "sources", "filters", "lib", "effects"):
        for path in (kernels_dir() / folder).glob("*.mako"):
            if path.stem in ("detector",):  # its numbers are a centre and a frame
                continue
            text = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
            assert not literal.search(text), path.name


def test_two_rows_of_one_name_do_not_share_a_scene():
    plain = room()
    other = replace(plain.element[1], surface=FiveNumbers(0.75))
    with pytest.raises(ValueError, match="a column LAMBERTIAN_REFLECTANCE, in two places"):
        compiled(replace(plain, element=(plain.element[0], other, plain.element[2])))


def test_two_classes_of_one_kind_are_refused():
    with pytest.raises(ValueError, match="two classes of the kind mirror"):
        registry._by_kind(pz.Mirror, pz.Lambertian, type("Other", (pz.Mirror,), {}))


def test_row_names_are_unique_over_the_registry():
    groups = (registry.ELEMENTS, registry.SURFACES, registry.SOURCES)
    for group in groups:
        rows = {cls.row for cls in group.values() if len(cls.row)}
        assert len({row.name for row in rows}) == len(rows)
