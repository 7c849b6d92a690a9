#!/usr/bin/python3
"""Fails if the reference page of the Python module is not up to date.

    PYTHONPATH=FOLDER_OF_THE_MODULE check_python_reference.py ROOT
"""

import sys
from pathlib import Path

sys.dont_write_bytecode = True  # no cache files in the source tree
root = Path(sys.argv[1])
sys.path.insert(0, str(root / "eval/python"))
import make_reference

PAGE = "docs/pages/reference/python.md"

if (root / PAGE).read_text(encoding="utf-8") != make_reference.page():
    sys.exit(f"{PAGE} is not up to date; run PYTHONPATH=build/release/python eval/python/make_reference.py {PAGE}")
