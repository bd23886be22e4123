"""`python -m porousmold` is the command `porousmold`."""

import sys

from .cli import main

sys.exit(main())
