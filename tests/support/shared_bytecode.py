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
    processes that tests start would compile SymPy and this package from their sources: most of its time.
    """
    kept = [Path(cache_from_source(find_spec(name).origin)) for name in ("sympy", "stickslip_sym")]
    may_keep = not sys.dont_write_bytecode and all(os.access(path.parents[1], os.W_OK) for path in kept)
    if may_keep or all(path.exists() for path in kept) or "PYTHONPYCACHEPREFIX" in os.environ:
        return
    folder = tempfile.mkdtemp(prefix="bytecode-of-tests-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = folder
    sys.dont_write_bytecode = False
