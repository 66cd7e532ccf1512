"""Makes the shared references importable."""

import pathlib
import sys

_here = pathlib.Path(__file__).resolve().parent
for _path in (str(_here.parent), str(_here)):
    if _path not in sys.path:
        sys.path.insert(0, _path)
