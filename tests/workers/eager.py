"""The command line, with a checkpoint a tenth of a second after the last one."""

from __future__ import annotations

import sys

from photizon_cl.cli.main import main
from photizon_cl.run import checkpoint

if __name__ == "__main__":
    checkpoint.PERIOD, checkpoint._SHARE = 0.1, 1e9
    sys.exit(main(sys.argv[1:]))
