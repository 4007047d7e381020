"""``python -m meshfair``."""

import sys

from meshfair.cli import main

sys.exit(main())
