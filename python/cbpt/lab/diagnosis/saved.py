"""Answers of a diagnosis that were saved, of this version or of an older one.

read_answer   a file, or a document, in the form of the present schema
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from cbpt.errors import InvalidInputError
from cbpt.lab.diagnosis.diagnosis import SCHEMA

__all__ = ["read_answer"]

_FIRST = "cbpt.diagnosis/1"
_VERDICT = {"kind", "effects", "rivals", "probability"}
_LATER_RUN = ("duration_s", "in_words", "most_probable", "runs", "untold")
"""Keys of `next_run` that the first schema has not."""


def read_answer(answer: str | os.PathLike[str] | Mapping[str, Any]) -> dict[str, Any]:
    """Read what `cbpt diagnose --json` or `Diagnosis.to_dict` wrote, today or before.

    Parameters
    ----------
    answer : path or mapping
        A JSON file of the schema `cbpt.diagnosis/1` or `/2`, or its document.

    Returns
    -------
    dict
        The document with the keys of `cbpt.diagnosis/2`. Of an answer of schema 1, what it did not
        say is None, or an empty list, and a note says so: its probability is that of the whole
        answer and nothing else.

    Raises
    ------
    InvalidInputError
        The file cannot be read, is no JSON, or is no answer of a diagnosis that is known here.
    """
    where = "the answer" if isinstance(answer, Mapping) else os.fspath(answer)
    document = deepcopy(dict(answer)) if isinstance(answer, Mapping) else _from_file(where)
    schema = document.get("schema")
    if schema not in (_FIRST, SCHEMA):
        raise InvalidInputError(
            f"{where}: schema is {schema!r}: expected {_FIRST!r} or {SCHEMA!r}, as `cbpt diagnose "
            "--json` writes; an answer of a newer version needs that version of cbpt",
            "schema",
            repr(schema),
            f"{_FIRST} or {SCHEMA}",
        )
    verdict = document.get("verdict")
    if not isinstance(verdict, dict) or not verdict.keys() >= _VERDICT:
        raise InvalidInputError(
            f"{where}: verdict has not all of {', '.join(sorted(_VERDICT))}: the document is not "
            "whole; write it once more with `cbpt diagnose --json`",
            "verdict",
        )
    run = document.get("next_run")
    if isinstance(run, dict) and "largest_gain" not in run:
        # What older versions called so is that of the two hypotheses that the run tells apart best.
        document["next_run"] = run | {"largest_gain": run.get("gain"), "gain": None}
    return document if schema == SCHEMA else _of_the_first(document)


def _from_file(path: str) -> dict[str, Any]:
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidInputError(f"{path}: {error.strerror}; check the path") from None
    except UnicodeDecodeError:
        raise InvalidInputError(f"{path}: not UTF-8 text, so no answer in JSON") from None
    except json.JSONDecodeError as error:
        raise InvalidInputError(
            f"{path}, line {error.lineno}: no JSON ({error.msg}); pass what `cbpt diagnose --json` "
            "wrote"
        ) from None
    if not isinstance(document, dict):
        raise InvalidInputError(f"{path}: expected one JSON object, an answer of a diagnosis")
    return document


def _of_the_first(document: dict[str, Any]) -> dict[str, Any]:
    """An answer of the first schema in the keys of the second; nothing is made up."""
    verdict = {
        **document["verdict"],
        "perhaps": [],
        "probability_exactly": None,
        "undecided": None,
    }
    run = document.get("next_run")
    note = (
        f"read from an answer of {_FIRST}: its probability is that of the whole answer and nothing "
        "else; combinations, what remains and what is likely were not told then"
    )
    return {
        **document,
        "schema": SCHEMA,
        "verdict": verdict,
        "combinations": [],
        "remains": None,
        "why": [],
        "closing": None,
        "next_run": {**dict.fromkeys(_LATER_RUN), **run} if isinstance(run, dict) else None,
        "notes": [*document.get("notes", []), note],
    }
