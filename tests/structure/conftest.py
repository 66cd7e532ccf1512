"""Makes the shared references importable, and what the tests here share, which lies beside them."""

import pathlib
import sys

for _folder in pathlib.Path(__file__).resolve().parents[:2]:
    if str(_folder) not in sys.path:
        sys.path.insert(0, str(_folder))
