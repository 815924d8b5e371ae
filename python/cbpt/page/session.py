"""What one workbench holds: a case, its readings, the diagnosis under way or done, further fits.

    Session     everything the page may ask for, without a word of HTTP

One at a time: whoever changes the session waits for its lock; a long diagnosis runs beside it and
is dropped where its readings have been replaced meanwhile.
"""

from __future__ import annotations

import re
import shlex
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from cbpt._core import Case, Drive, OwnEffect
from cbpt.effects import doubtful_names, expression
from cbpt.errors import CaseError, CbptError, InvalidInputError, ReadingsError
from cbpt.lab.inputs import case_and_readings
from cbpt.lab.readings import Readings
from cbpt.page.document import Source, page_document
from cbpt.page.drive import redrawn
from cbpt.page.job import Cancelled, Job
from cbpt.page.models import Models
from cbpt.page.plain import to_json
from cbpt.page.tables import csv_of
from cbpt.page.uploads import Upload, read_case, shown_name

MOST_EFFECTS = 8
_NOTHING = "there are no readings yet: open a case file and a table of readings first"
_ASK_FOR_IT = "what this campaign could see is worked out when it is asked for"
_NO_DIAGNOSIS = "the readings have to be diagnosed first"


class NotNow(CbptError):
    """Something that cannot be done in the state that the session is in."""


class Session:
    """See the module's head."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._matrix = threading.Lock()
        self._case: Case | Drive | None = None
        self._case_name = self._case_text = ""
        self._case_words = self._data_words = ""
        self._upload: Upload | None = None
        self._readings: Readings | None = None
        self._flags: list[str] = []
        self._models: Models | None = None
        self._job: Job | None = None
        self._document: dict[str, Any] | None = None
        self._text: str | None = None

    # --- files ---

    @classmethod
    def of_files(
        cls,
        case: Path,
        data: Path,
        columns: Mapping[str, str] | None = None,
        sheet: str | None = None,
        only: Mapping[str, str] | None = None,
        flags: Sequence[str] = (),
    ) -> Session:
        """With files from disk. Raises `CaseError` and `ReadingsError`."""
        session = cls()
        session._case, session._readings = case_and_readings(
            case, data, dict(columns or {}) or None, sheet, only
        )
        session._case_text = case.read_text(encoding="utf-8-sig")
        session._case_words, session._data_words = str(case), str(data)
        session._case_name = case.name
        session._upload = Upload(data.name, str(data), dict(columns or {}), sheet)
        session._flags = list(flags)
        return session

    def take(self, name: str, raw: bytes) -> dict[str, Any]:
        """A file that was handed over: a case where it is TOML, else a table."""
        if name.lower().endswith(".toml"):
            return self.take_case(shown_name(name, "case.toml"), raw)
        return self.take_table(shown_name(name, "table"), raw)

    def take_case(self, name: str, raw: bytes) -> dict[str, Any]:
        """A case; the readings are read anew with it. Raises `CaseError`."""
        case, text = read_case(name, raw)
        with self._lock:
            self._drop()
            self._case, self._case_name, self._case_text = case, name, text
            self._case_words = name
            return self._read()

    def take_table(self, name: str, raw: bytes) -> dict[str, Any]:
        """A table. Raises `ReadingsError` for what is too large."""
        upload = Upload.of_bytes(name, raw)
        with self._lock:
            self._drop()
            if self._upload is not None:
                self._upload.close()
            self._upload, self._data_words, self._flags = upload, name, []
            return self._read()

    def map_columns(self, columns: Mapping[str, str], sheet: str | None) -> dict[str, Any]:
        """What the columns of the table mean, as the user says."""
        with self._lock:
            if self._upload is None:
                raise NotNow("there is no table yet whose columns could be told")
            self._drop()
            self._upload.columns, self._upload.sheet = dict(columns), sheet
            self._flags = []
            for header, meaning in columns.items():
                self._flags += ["--column", f"{header}={meaning}"]
            if sheet is not None:
                self._flags += ["--sheet", sheet]
            return self._read()

    def _drop(self) -> None:
        """What was found of other files is nothing worth any more."""
        if self._job is not None:
            self._job.cancel()
        self._readings = self._models = self._document = self._text = self._job = None

    def _read(self) -> dict[str, Any]:
        """The readings, where case and table are there; and what is missing or in doubt."""
        found: dict[str, Any] = {"ready": False, "message": "", "columns": [], "quantities": []}
        if self._upload is None:
            return found | {"message": f"{self._case_name} is read; now a table of readings."}
        found |= self._upload.describe()
        if self._case is None:
            return found | {"message": f"{self._upload.name} is here; now the case file (TOML)."}
        case = self._case
        if isinstance(case, Drive):
            case = Case.from_toml(case.to_toml())
        try:
            self._readings = self._upload.readings(case)
        except ReadingsError as error:
            problem = self._upload.told(error)
            return found | {"problem": problem, "message": problem["error"], "doubt": True}
        return found | {"ready": True, "message": "", "rows": len(self._readings)}

    # --- the document ---

    def document(self) -> str | None:
        """The page's document as JSON; None while there is nothing to show."""
        with self._lock:
            if self._text is None and self._readings is not None:
                self._document = self._made(None, None, None)
                self._text = to_json(self._document)
            return self._text

    def _made(
        self, models: Models | None, isolability: Mapping[str, Any] | None, why: str | None
    ) -> dict[str, Any]:
        assert self._case is not None
        assert self._readings is not None
        assert self._upload is not None
        words = ["cbpt", "report", self._case_words, self._data_words, *self._flags]
        source = Source(
            self._case_name,
            self._upload.name,
            self._case_text,
            shlex.join([*words, "--out", "report.html"]),
        )
        return page_document(
            self._case,
            self._readings,
            source,
            None if models is None else models.diagnosis,
            models=models,
            isolability=isolability,
            reasons={"isolability": why} if why else None,
        )

    # --- the diagnosis ---

    def start(self, seed: int = 0) -> dict[str, Any]:
        """Begin a diagnosis. Raises `NotNow` where one is under way or nothing is there."""
        with self._lock:
            if self._case is None or self._readings is None:
                raise NotNow(_NOTHING)
            if self._job is not None and self._job.running:
                raise NotNow("a diagnosis is under way; wait for it or cancel it")
            case, readings = self._case, self._readings

            def work(step: Callable[[str, float], None]) -> None:
                self._diagnose(case, readings, seed, step)

            self._job = Job(work).start()
            return self._job.to_dict()

    def _diagnose(
        self,
        case: Case | Drive,
        readings: Readings,
        seed: int,
        step: Callable[[str, float], None],
    ) -> None:
        from cbpt.lab.diagnose import diagnose

        diagnosis = diagnose(
            case, readings, seed=seed, progress=lambda what, share: step(what, 0.9 * share)
        )
        step("the answer", 0.9)
        models = Models(diagnosis, readings)
        document = self._made(models, None, _ASK_FOR_IT)
        text = to_json(document)
        with self._lock:
            if readings is not self._readings:
                raise Cancelled
            self._models, self._document, self._text = models, document, text

    def isolability(self) -> dict[str, Any]:
        """What this campaign could see and tell apart, worked out when first asked for: some
        seconds, which the answer does not wait for."""
        from cbpt.page.campaign import campaign_isolability

        models = self._diagnosed()

        def step(what: str, share: float) -> None:
            if models is not self._models:
                raise NotNow("other files have been opened meanwhile")

        with self._matrix:
            document = self._document
            if document is not None and document["reasons"].get("isolability") == _ASK_FOR_IT:
                found, why = campaign_isolability(models.diagnosis, step)
                with self._lock:
                    step("", 1.0)
                    document["isolability"] = found
                    document["reasons"]["isolability"] = why
                    if why is None:
                        del document["reasons"]["isolability"]
                    self._text = to_json(document)
            assert document is not None
            why = document["reasons"].get("isolability")
            return {"isolability": document["isolability"], "why": why}

    def job(self) -> dict[str, Any]:
        """How far the diagnosis is."""
        job = self._job
        if job is None:
            return {"state": "idle", "stage": "", "share": 0.0, "seconds": 0.0, "error": ""}
        return job.to_dict()

    def cancel(self) -> dict[str, Any]:
        """No longer wanted."""
        if self._job is not None:
            self._job.cancel()
        return self.job()

    def begin(self) -> None:
        """Where files were given: the page first, then the diagnosis."""
        if self.document() is not None:
            self.start()

    def join(self, seconds: float) -> bool:
        """Wait for the diagnosis; False where it has not ended by then."""
        return self._job is None or self._job.join(seconds)

    def close(self) -> None:
        """At the end: whatever is under way stops soon."""
        if self._job is not None:
            self._job.cancel()
            self._job.join(5.0)
        if self._upload is not None:
            self._upload.close()

    # --- further models ---

    def model(self, effects: Sequence[str]) -> dict[str, Any]:
        """The model with some effects. Raises `InvalidInputError`, `NotNow`."""
        if len(effects) > MOST_EFFECTS:
            raise InvalidInputError(f"{len(effects)} effects, expected at most {MOST_EFFECTS}")
        return self._diagnosed().choice(effects)

    def _diagnosed(self) -> Models:
        models = self._models
        if models is None:
            raise NotNow(_NOTHING if self._readings is None else _NO_DIAGNOSIS)
        return models

    def check_own(self, entry: Mapping[str, Any]) -> dict[str, Any]:
        """Whether an own effect can be read, else what is wrong and at which character; notes are
        what may be a slip all the same."""
        try:
            effect = own_effect_of(entry)
        except (CaseError, InvalidInputError) as error:
            text = str(error).removeprefix("effect[0].")
            at = _CHARACTER.search(text)
            return {
                "ok": False,
                "message": at[2] if at else text,
                "column": int(at[1]) if at else None,
                "notes": [],
            }
        return {"ok": True, "message": "", "column": None, "notes": doubtful_names(effect)}

    def fit_own(self, entry: Mapping[str, Any], effects: Sequence[str] = ()) -> dict[str, Any]:
        """An own effect fitted, alone or with others."""
        effect = own_effect_of(entry)
        models = self._diagnosed()
        models.add_own(effect)
        return self.model([*(e for e in effects if e != effect.id), effect.id])

    # --- the drive ---

    def drive(self, load: Mapping[str, float], design: Mapping[str, float]) -> dict[str, Any]:
        """The drive at another load, with other numbers."""
        case, readings = self._case, self._readings
        if case is None or readings is None:
            raise NotNow(_NOTHING)
        return redrawn(case, readings, load, design)

    # --- to take away ---

    def exported(self, what: str, effects: Sequence[str]) -> tuple[str, str, str]:
        """Text, type and file name of `json`, `csv`, `case` or `command`, of the model with some
        effects where there is one."""
        text = self.document()
        if text is None or self._document is None:
            raise NotNow(_NOTHING)
        stem = self._stem()
        if what == "json":
            return text, "application/json", f"{stem}_page.json"
        if what == "command":
            return self._command(effects) + "\n", "text/plain", f"{stem}_command.txt"
        entry = self._document["models"][0]
        if effects:
            entry = self.model(effects)["model"]
        if what == "csv":
            return csv_of(self._document, entry), "text/csv", f"{stem}_readings.csv"
        if what == "case":
            case = entry["case_text"] or self._case_text
            return case, "application/toml", f"{stem}_case.toml"
        raise NotNow(f"nothing is exported as {what!r}: json, csv, case or command")

    def _command(self, effects: Sequence[str]) -> str:
        """The command line that gives the same."""
        words = [self._case_words, self._data_words, *self._flags]
        if not effects:
            return shlex.join(["cbpt", "report", *words, "--out", "report.html"])
        own = {effect.id for effect in self._diagnosed().own}
        if own & set(effects):
            # A formula is known to the exported case alone.
            words[0] = f"{self._stem()}_case.toml"
        return shlex.join(["cbpt", "fit", *words, "--with", *effects, "--out", "case_with.toml"])

    def _stem(self) -> str:
        assert self._upload is not None
        return re.sub(r"[^\w.-]+", "_", Path(self._upload.name).stem) or "cbpt"


_CHARACTER = re.compile(r"character (\d+): (.*)", re.DOTALL)
_OWN_KEYS = {"id", "port", "expression", "adds_to", "parameters"}
_PARAMETER_KEYS = ("unit", "start", "min", "max")


def own_effect_of(entry: Mapping[str, Any]) -> OwnEffect:
    """An own effect from what the page sends: as in a case file, the parameters as a list."""
    for key in ("id", "port", "expression"):
        if not isinstance(entry.get(key), str):
            raise InvalidInputError(f"{key}: expected text")
    parameters = entry.get("parameters") or []
    if not isinstance(parameters, list) or not all(isinstance(p, dict) for p in parameters):
        raise InvalidInputError("parameters: expected a list")
    named = {
        str(p.get("name", "")): {k: p[k] for k in _PARAMETER_KEYS if p.get(k) is not None}
        for p in parameters
    }
    if len(named) < len(parameters):
        raise InvalidInputError("parameters: two have the same name")
    adds_to = entry.get("adds_to")
    return expression(
        entry["id"],
        entry["port"],
        entry["expression"],
        named,
        adds_to=adds_to if isinstance(adds_to, str) else None,
    )
