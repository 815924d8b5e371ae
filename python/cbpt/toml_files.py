"""Files in TOML that people write for the verbs of Python: plans of campaigns, bounds of designs.

    read_toml   the tables of a file, or why there are none
    shown       a value of such a file in a message
    is_number   whether a value is one that can be computed with

Case files and plans of sweeps have their parser in Rust. Whatever is in a file, reading it takes a
time that grows with its length, and ends with an error of the package.
"""

from __future__ import annotations

import math
import os
import re
import reprlib
import tomllib
from pathlib import Path
from typing import Any, TypeGuard

from cbpt.errors import CbptError

__all__ = ["is_number", "read_toml", "shown"]

LARGEST = 1 << 20
"""Bytes; what is larger is another file."""
DEEPEST = 8
"""Parts of a dotted key, and tables and lists within each other."""
LONGEST_KEY = 200
"""Signs."""

_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
# tomllib takes a time that grows with the cube of the parts of a key.
_DEEP_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{DEEPEST},}}")


def read_toml(path: str | os.PathLike[str], error: type[CbptError], what: str) -> dict[str, Any]:
    """The tables of a file. what: what the file is to be, for messages. Raises `error`."""
    name = os.fsdecode(path)
    try:
        with Path(name).open("rb") as file:
            raw = file.read(LARGEST + 1)
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise error(f"{name}: found no UTF-8 text, expected {what}") from None
    except (OSError, ValueError) as why:  # ValueError: a NUL in the path
        told = getattr(why, "strerror", None) or str(why)
        raise error(f"{name}: {told}, expected {what}") from None
    if len(raw) > LARGEST:
        raise error(f"{name}: found more than 1 MiB, expected {what}")
    deep = f"{name}: found more than {DEEPEST} levels of keys or lists, expected {what}"
    if chain := _DEEP_KEY.search(text):
        line = text.count("\n", 0, chain.start()) + 1
        raise error(f"{deep} (at line {line})")
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise error(deep) from None
    except tomllib.TOMLDecodeError as why:
        raise error(f"{name}: not TOML: {why}, expected {what}") from None
    except ValueError:
        odd = "a whole number of thousands of digits, or a date that is none"
        raise error(f"{name}: found {odd}, expected {what}") from None
    depth, key = _extent(tables)
    if depth > DEEPEST:
        raise error(deep)
    if len(key) > LONGEST_KEY:
        raise error(f"{name}: found the key {key[:40]}... of {len(key):,} signs, expected {what}")
    return tables


def _extent(tables: dict[str, Any]) -> tuple[int, str]:
    """How many tables and lists lie within each other, and the longest key."""
    depth, longest = 0, ""
    level: list[Any] = [tables]
    while level:
        depth += 1
        keys = (key for each in level if isinstance(each, dict) for key in each)
        longest = max(longest, max(keys, key=len, default=""), key=len)
        inside = (each.values() if isinstance(each, dict) else each for each in level)
        level = [value for each in inside for value in each if isinstance(value, dict | list)]
    return depth, longest


class _Shown(reprlib.Repr):
    """A value in a few words, however large it is."""

    def repr_int(self, x: int, level: int) -> str:
        digits = int(x.bit_length() * math.log10(2)) + 1
        return repr(x) if digits <= 60 else f"a whole number of about {digits:,} digits"


_SHOWN = _Shown()
_SHOWN.maxstring = _SHOWN.maxother = 200
_SHOWN.maxlist = _SHOWN.maxdict = _SHOWN.maxtuple = 8


def shown(value: object) -> str:
    """A value as it may stand in a message."""
    return _SHOWN.repr(value)


def is_number(value: object) -> TypeGuard[int | float]:
    """Whether it is a finite number, of a size that a float has."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # of a whole number
        return False
