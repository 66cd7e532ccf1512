"""What escapes, by direction."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from hostcode.program.parts import EffectParts
from photizon_cl.compile.effects.base import Effect
from photizon_cl.scene.edges import azimuth_edges, even_edges
from photizon_cl.scene.frames import sincos_deg

if TYPE_CHECKING:
    from collections.abc import Iterator

    from photizon_cl.compile.draft import Draft
    from photizon_cl.scene.far_field import FarField as Bins
    from photizon_cl.scene.model import Scene
    from photizon_cl.scene.settings import RunSettings


class FarField(Effect):
    """What escapes is binned by direction."""

    name: ClassVar[str] = "far-field"
    what: ClassVar[str] = "what escapes is binned by direction"
    costs: ClassVar[str] = "a terminal record and an exact-edge search an escape"
    removable: ClassVar[bool] = True

    def needed(self, scene: Scene, settings: RunSettings) -> str | None:
        """Where the scene asks for it."""
        return "the scene has a [far_field]" if scene.far_field is not None else None

    def absent(self, scene: Scene, settings: RunSettings) -> str:
        """Say what the scene has not."""
        return "the scene has no [far_field]"

    def possible(self, scene: Scene) -> bool:
        """Not without bins."""
        return scene.far_field is not None

    def cells(self, scene: Scene) -> tuple[int, ...]:
        """Return the numbers of rows and columns."""
        assert scene.far_field is not None
        return scene.far_field.rows, scene.far_field.n_phi

    def parts(self, draft: Draft) -> EffectParts:
        """Return the binning of escapes: by world components, or in a frame of the far field's."""
        far = draft.scene.far_field
        assert far is not None
        columns = (
            ("n_phi", "ulong", "far-field bins in phi"),
            ("phi_edges", "ulong", "where in edges those in phi stand"),
        )
        first = ("far_field", "ulong", "first cell of the far field")
        if far.turned or far.by_theta:
            return EffectParts(
                templates=(("tally", "effects/far_field_about"),),
                records=("escapes",),
                launch=(
                    first,
                    ("n_rows", "ulong", "far-field bins in theta or cos theta"),
                    ("far_rows", "ulong", "where in edges those stand"),
                    ("far_frame", "ulong", "where in edges the frame stands"),
                    *columns,
                ),
                parameters=(("far_field_theta", int(far.by_theta)),),
            )
        return EffectParts(
            templates=(("tally", "effects/far_field"),),
            records=("escapes",),
            launch=(
                first,
                ("n_mu", "ulong", "far-field bins in cos theta"),
                columns[0],
                ("mu_edges", "ulong", "where in edges those in cos theta stand"),
                columns[1],
            ),
        )

    def assemble(self, draft: Draft) -> None:
        """Add the bins and their edges."""
        far = draft.scene.far_field
        assert far is not None
        launch = draft.launch
        if far.turned or far.by_theta:
            launch["n_rows"], launch["n_phi"] = far.rows, far.n_phi
            launch["far_frame"] = draft.add_edges(x for row in far.frame for x in row)
            launch["far_rows"] = draft.add_edges(_rows(far))
        else:
            launch["n_mu"], launch["n_phi"] = far.rows, far.n_phi
            launch["mu_edges"] = draft.add_edges(_rows(far))
        launch["phi_edges"] = draft.add_edges(azimuth_edges(far.n_phi))


def _rows(far: Bins) -> Iterator[float]:
    """Give the edges of the rows as the kernels take them: cos θ, or cosine and sine of each θ."""
    if not far.by_theta:
        yield from even_edges(-1.0, 1.0, far.rows)
        return
    for angle in far.edges_deg:
        sine, cosine = sincos_deg(angle)
        yield cosine
        yield sine
