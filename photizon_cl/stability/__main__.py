"""``python -m photizon_cl.stability``."""

import sys

from photizon_cl.stability import main

sys.exit(main())
