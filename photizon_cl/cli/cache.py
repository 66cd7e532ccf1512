"""The verb ``cache``: the kernels that are kept from one run to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from photizon_cl.errors import ArgumentError, show

if TYPE_CHECKING:
    import argparse

__all__ = ["add_arguments", "call"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the verb takes."""
    parser.add_argument(
        "--clear", action="store_true", help="remove them, and what is known of self-tests"
    )


def call(arguments: argparse.Namespace) -> int:
    """Print what is kept, or remove it; return the exit status."""
    from hostcode.device import kernel_cache, known_passes

    folder, tests = kernel_cache.root(), known_passes.cache_file()
    files, size = kernel_cache.remove_kept() if arguments.clear else kernel_cache.kept()
    if arguments.clear and next(kernel_cache.kept_files(), None) is not None:
        raise ArgumentError(f"cache: {show(str(folder))} cannot be cleared: remove it by hand")
    word = "removed" if arguments.clear else "kept"
    programs = "1 program" if files == 1 else f"{files} programs"
    print(f"compiled kernels: {programs}, {size / 1e6:.1f} MB, {word}: {folder}")
    known = known_passes.forget() if arguments.clear else known_passes.count()
    passes = "1 pass" if known == 1 else f"{known} passes"
    print(f"self-tests of devices: {passes} {'forgotten' if arguments.clear else 'known'}: {tests}")
    return 0
