"""`python -m addon COMMAND …`: the command line where only the `bpy` module is installed."""

import sys

from .cli.main import main

sys.exit(main(sys.argv[1:]))
