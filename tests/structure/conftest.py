from __future__ import annotations

import sys
from pathlib import Path

# What the tests here share lies beside them; tests are no package.
sys.path.insert(0, str(Path(__file__).resolve().parent))
