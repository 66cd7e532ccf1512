"""A file of which bytes were lost is told before HDF5 reads it: it may never come back."""

from __future__ import annotations

import random
import signal

import h5py
import pytest
import xarray as xr

import photizon_cl as pz
from photizon_cl.cli.main import main
from photizon_cl.result.sealing import deaf_libraries_end, seal, sealed


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("sealed")
    pz.trace("box-room", batches=3, rays_per_batch=256).save(made, figures=False)
    return made


def test_every_byte_counts(folder, tmp_path):
    data = (folder / "result.nc").read_bytes()
    draw = random.Random(1)
    file = tmp_path / "result.nc"
    places = [0, len(data) - 1, len(data) - 40, len(data) - 100]
    for at in places + [draw.randrange(len(data)) for _ in range(60)]:
        n = draw.choice([1, 2, 64, 512])
        lost = data[:at] + bytes(min(n, len(data) - at)) + data[at + n :]
        if lost == data:
            continue
        file.write_bytes(lost)
        with pytest.raises(pz.ResultError, match="is damaged or not a photizon result"):
            pz.open_result(tmp_path)
    assert main(["report", str(tmp_path)]) == 2
    file.write_bytes(data)
    assert pz.open_result(tmp_path).batches == 3


def test_checkpoints_are_sealed_too(tmp_path):
    kept = tmp_path / "checkpoint.nc"
    seen = []

    def look(progress):
        seen.append(sealed(kept))

    run = {"batches": 4, "rays_per_batch": 256, "checkpoint": tmp_path}
    pz.trace("box-room", **run, progress=look)
    assert seen
    assert all(seen)
    data = kept.read_bytes()
    kept.write_bytes(data[:9000] + bytes(512) + data[9512:])
    assert main(["resume", str(tmp_path)]) == 2


def test_other_readers_read_it_as_it_is(folder):
    with xr.open_dataset(folder / "result.nc", engine="h5netcdf") as data:
        assert "ledger.power" in data
    with h5py.File(folder / "result.nc", "r") as raw:
        assert "tally" in raw


def test_files_without_a_seal_are_read_by_their_own_checksum(folder, tmp_path):
    data = (folder / "result.nc").read_bytes()
    file = tmp_path / "result.nc"
    file.write_bytes(data[: data.rindex(b"\nphotizon sha256:")])
    assert not sealed(file)
    assert pz.open_result(file).tally_digest == pz.open_result(folder).tally_digest
    seal(file)
    assert file.read_bytes() == data
    (tmp_path / "short").write_bytes(b"x")
    assert not sealed(tmp_path / "short")


def test_signals_end_a_library_that_does_not_come_back():
    with deaf_libraries_end():
        assert signal.getsignal(signal.SIGINT) is signal.SIG_DFL
    assert callable(signal.getsignal(signal.SIGINT))
