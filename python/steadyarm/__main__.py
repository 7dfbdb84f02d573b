"""``python -m steadyarm``, the same as the command ``steadyarm``."""

import sys

from .cli import main

sys.exit(main())
