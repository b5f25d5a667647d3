"""`python -m cavalcade` is the command line."""

import sys

from cavalcade.cli import main

sys.exit(main())
