"""The verb ``devices``: every OpenCL device, and which one is chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import argparse

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare nothing: the verb takes no arguments."""


def call(arguments: argparse.Namespace) -> int:
    """Print every device with what it can do and why it is refused; return the exit status."""
    from rich.text import Text

    from hostcode.device.capability import INSTALL_HINT, survey
    from hostcode.device.device import explain_choice, qualify
    from hostcode.errors import DeviceError
    from photizon_cl.cli.tables import console, paragraph

    out = console()
    found = survey()
    for record in found.records:
        reasons = qualify(record, self_test=True)
        number = f"{record.index} ({record.platform_index}:{record.device_index})"
        verdict = ("refused", "bold red") if reasons else ("usable", "bold green")
        out.print(Text.assemble((number, "bold"), f"  {record.type}  {record.name}  ", verdict))
        out.print(paragraph(f"{record.platform}, driver {record.driver}", "    "), soft_wrap=True)
        memory = record.global_memory / 2**30
        precision = "fp64" if record.fp64 else "no fp64"
        precision += ", fp32 to the bit" if record.fp32_exact else ", fp32 not to the bit"
        atomics = "int64 atomics" if record.int64_atomics else "no int64 atomics"
        facts = (
            f"{record.compute_units} compute units, {memory:.1f} GiB, {precision}, {atomics}, "
            f"{max(record.native_vector_width_double, 1)} doubles wide"
        )
        out.print(paragraph(facts, "    "), soft_wrap=True)
        for reason in reasons:
            out.print(paragraph(f"refused: {reason}", "    "), soft_wrap=True)
    for problem in found.problems:
        out.print(paragraph(f"not readable: {problem}", ""), soft_wrap=True)
    try:
        choice = explain_choice()
    except DeviceError as error:
        out.print(paragraph(str(error) if found.records else f"no device: {INSTALL_HINT}", ""))
        return 1
    out.print()
    out.print(paragraph(f"chosen: {choice.record.label}, {choice.reason}", ""), soft_wrap=True)
    return 0
