"""In what systems differ, as far as tests see it: what is skipped where, and why."""

import errno
import os

import pytest

WINDOWS = os.name == "nt"

needs_posix_shell = pytest.mark.skipif(WINDOWS, reason="needs a POSIX shell, its pipes and devices")
needs_links = pytest.mark.skipif(WINDOWS, reason="Windows lets administrators only make symbolic links")
needs_modes = pytest.mark.skipif(WINDOWS, reason="Windows has no permissions for the owner and the group")
needs_long_names = pytest.mark.skipif(WINDOWS, reason="Windows bounds the whole path, not a name in it")

FOLDER_OPENED = os.strerror(errno.EACCES if WINDOWS else errno.EISDIR)
"""What the system says to a folder that is opened as a file."""
