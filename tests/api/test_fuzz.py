"""Some hundred random mutations of each kind; `python tests/api/fuzz.py --n 3000` for thousands."""

from __future__ import annotations

import fuzz
import pytest


@pytest.mark.slow
@pytest.mark.parametrize("kind", fuzz.KINDS)
def test_nothing_wrong_is_accepted(kind, tmp_path):
    outcomes, wrong, _ = fuzz.search(kind, 200, 50_000, tmp_path)
    assert not wrong, wrong[:3]
    assert len(outcomes) > 1  # some are refused, and some are not
