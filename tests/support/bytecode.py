"""Compiled modules that all processes of a test run share, where Python keeps none."""

import atexit
import os
import shutil
import sys
import tempfile
from importlib.util import cache_from_source, find_spec
from pathlib import Path


def share_bytecode():
    """Let this process and those it starts keep compiled modules, in a folder that goes with this process.

    Where Python is told to keep none, or may not, and none came with the installation, each of the hundred
    processes that tests start would compile SymPy from its source: 4 seconds of the 5 that it takes to begin.
    """
    kept = Path(cache_from_source(find_spec("sympy").origin))
    may_keep = not sys.dont_write_bytecode and os.access(kept.parents[1], os.W_OK)
    if kept.exists() or may_keep or "PYTHONPYCACHEPREFIX" in os.environ:
        return
    folder = tempfile.mkdtemp(prefix="bytecode-of-tests-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = folder
    sys.dont_write_bytecode = False
