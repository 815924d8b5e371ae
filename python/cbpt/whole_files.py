"""Files that are written whole or not at all.

    write_whole   text or bytes to a file
    whole         a name to write to, in whose place the file stands once all is well

What is written goes to a new file in the same folder, then to the disk, and takes the place of the
old one in a single step: whatever fails, the old file is still there as it was. A symbolic link is
followed: the file that it leads to is replaced, and the link stays. What is no plain file
(/dev/stdout, a pipe) is written to as it is. A file that is replaced keeps its permissions.
"""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

__all__ = ["whole", "write_whole"]


def write_whole(path: str | os.PathLike[str], contents: str | bytes) -> None:
    """Write a file, text as UTF-8. Raises `OSError`, with the name of the file, where it cannot."""
    if isinstance(contents, str):  # half a character, of a header for example, has no UTF-8
        contents = contents.encode("utf-8", "backslashreplace")
    with whole(path) as new:
        new.write_bytes(contents)


@contextmanager
def whole(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Inside of it, the name of a file to write; behind it, that file stands at `path`.

    Raises `OSError`, with the name of the file, where it cannot be written.
    """
    target = Path(os.path.realpath(path))
    new = target.with_name(f".{target.name[:100]}.{secrets.token_hex(4)}.new")
    try:
        if target.exists() and not target.is_file():
            yield target
            return
        # Made as any new file is, so that its permissions are those of the user's files.
        os.close(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        yield new
        if target.exists():
            shutil.copymode(target, new)
        _to_disk(new)
        new.replace(target)
        with suppress(OSError):  # where a folder cannot be opened
            _to_disk(target.parent)
    except OSError as error:
        words = error.strerror or str(error)
        raise OSError(error.errno or errno.EIO, words, os.fspath(path)) from error
    finally:
        with suppress(OSError):
            new.unlink()


def _to_disk(path: Path) -> None:
    file = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(file)
    finally:
        os.close(file)
