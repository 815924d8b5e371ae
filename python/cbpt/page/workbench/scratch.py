"""Folders of our own for what a browser hands over: gone with their end, or at the next start.

    Scratch   a folder that is locked as long as it is in use
    sweep     removes what workbenches have left that were killed

The lock is the system's and ends with the process, however that ends; so what nobody has locked
belongs to nobody any more. Where there are no such locks (Windows) nothing is swept.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

_PREFIX = "cbpt-workbench-"
_LOCK = "lock"


class Scratch:
    """A folder of our own, at `path`."""

    def __init__(self) -> None:
        while True:
            self.path = Path(tempfile.mkdtemp(prefix=_PREFIX))
            self._lock = _locked(self.path, "x")
            # A sweep may have come in between, and taken it for one that is left.
            if self._lock is not None and (self.path / _LOCK).exists():
                return
            self.close()

    def close(self) -> None:
        """Remove it."""
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock is not None:
            self._lock.close()
            self._lock = None


def sweep() -> None:
    """Remove the folders of this user that no process has locked."""
    if os.name != "posix":
        return
    for folder in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        try:
            mine = not folder.is_symlink() and folder.stat().st_uid == os.getuid()
        except OSError:
            continue
        if mine and (lock := _locked(folder, "r+")) is not None:
            shutil.rmtree(folder, ignore_errors=True)
            lock.close()


def _locked(folder: Path, mode: str) -> Any:
    """The lock of a folder; None where another process has it, or where it is gone."""
    try:
        file = (folder / _LOCK).open(mode)
    except OSError:
        return None
    try:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except ImportError:
        pass
    except OSError:
        file.close()
        return None
    return file
