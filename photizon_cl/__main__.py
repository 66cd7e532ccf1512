"""``python -m photizon_cl VERB …`` is ``photizon VERB …``."""

from __future__ import annotations

import sys

from photizon_cl.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
