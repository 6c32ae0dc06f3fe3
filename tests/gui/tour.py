"""A first-time user's way through the extension, in a real window. Each step is a claim; the pictures serve the documentation."""

import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # its folder is known only now
for part in ("panels", "windows", "live", "tools", "impostors", "leaving"):
    importlib.import_module(f"tour_{part}")  # which takes its steps up
importlib.import_module("harness").run(sys.argv[sys.argv.index("--") + 1 :])
