"""What one workbench holds: a case, its readings, the diagnosis under way or done, further fits.

    Session     everything the page may ask for, without a word of HTTP

One at a time: whoever changes the session waits for its lock, and files are read one after the
other before it is taken; a long diagnosis runs beside it and is dropped where its readings have
been replaced meanwhile. While nobody asks for anything, models that are likely to be asked for next
are prepared (see `ahead`).
"""

from __future__ import annotations

import json
import re
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cbpt._core import Case, Drive, OwnEffect
from cbpt.effects import doubtful_names
from cbpt.errors import CaseError, CbptError, InvalidInputError
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.readings.reader import Readings
from cbpt.page.document.document import Isolability, first_document
from cbpt.page.document.drive import redrawn
from cbpt.page.document.drive_types import DriveSection
from cbpt.page.document.plain import to_json
from cbpt.page.document.source import Source, as_word, from_here, named
from cbpt.page.document.tables import csv_of
from cbpt.page.document.types import ChangeSection, PageDocument
from cbpt.page.workbench.ahead import Ahead, Effects, Step, Turns
from cbpt.page.workbench.job import Cancelled, Job
from cbpt.page.workbench.scratch import sweep
from cbpt.page.workbench.uploads import Opened, Upload, read_case, shown_name, stop_if_few

if TYPE_CHECKING:
    from cbpt.page.document.models import Models

MOST_EFFECTS = 8
_MOST_PLACES = 20
"""Of readings that are left out, as stretches."""
CLOSING_S = 1.0
"""How long the end may wait for what is under way, all together."""
_NOTHING = "there are no readings yet: open a case file and a table of readings first"
_ASK_FOR_IT = "the detection limits of this campaign are computed when the workbench is idle"
_ENDING = "the workbench is ending"
_NO_DIAGNOSIS = "the readings have to be diagnosed first"


class NotNow(CbptError):
    """Something that cannot be done in the state that the session is in."""


class Session:
    """See the module's head."""

    def __init__(self) -> None:
        self._opening = threading.Lock()
        """Of who reads files: the others may go on asking about those that are shown."""
        self._lock = threading.RLock()
        self._matrix = threading.Lock()
        self._tables = threading.Lock()
        self._turns = Turns()
        self._shown = Opened()
        self._next: Opened | None = None
        """Files on their way: they are shown once readings come of them, not before."""
        self._readings: Readings | None = None
        self._all: Readings | None = None
        """With those that somebody has left out."""
        self.opened = 0
        """Counts the files that have been shown, so that no answer is taken for one to others."""
        self._models: Models | None = None
        self._ahead: Ahead | None = None
        self._job: Job | None = None
        self._seed = 0
        self._stopped_s = 0.0
        self._document: PageDocument | None = None
        self._text: str | None = None

    # --- files ---

    @classmethod
    def of_files(
        cls,
        case: Path,
        data: Path,
        columns: Mapping[str, str] | None = None,
        sheet: str | None = None,
        only: Mapping[str, Sequence[str]] | None = None,
        flags: Sequence[str] = (),
    ) -> Session:
        """With files from disk. Raises `CaseError` and `ReadingsError`."""
        session = cls()
        read, readings = case_and_readings(case, data, dict(columns or {}) or None, sheet, only)
        stop_if_few(data.name, readings)
        session._readings = session._all = named(readings, str(data), data.name)
        session._shown = Opened(
            read,
            case.name,
            case.read_text(encoding="utf-8-sig"),
            from_here(str(case)),
            Upload(data.name, str(data), dict(columns or {}), sheet, dict(only or {}) or None),
            from_here(str(data)),
            tuple(flags),
        )
        return session

    def take(self, name: str, raw: bytes, more: bool = False) -> dict[str, Any]:
        """A file that was handed over: a case where it is TOML, else a table. more: others follow,
        with which it is read. Raises `CaseError`, and `ReadingsError` for what is too large."""
        found: dict[str, Any]
        if name.lower().endswith(".toml"):
            name = shown_name(name, "case.toml")
            case, text = read_case(name, raw)
            found = {"case": case, "case_name": name, "case_text": text}
            found["case_words"] = as_word(name)
        else:
            name = shown_name(name, "table")
            found = {"upload": Upload.of_bytes(name, raw), "flags": ()}
            found["data_words"] = as_word(name)
        with self._opening:
            return self._open(replace(self._latest, **found), more)

    def map_columns(self, columns: Mapping[str, str], sheet: str | None) -> dict[str, Any]:
        """What the columns of the table mean, as the user says."""
        with self._opening:
            latest = self._latest
            if latest.upload is None:
                raise NotNow("there is no table yet whose columns could be told")
            flags = []
            for header, meaning in columns.items():
                flags += ["--column", f"{header}={meaning}"]
            if sheet is not None:
                flags += ["--sheet", sheet]
            upload = replace(latest.upload, columns=dict(columns), sheet=sheet)
            return self._open(replace(latest, upload=upload, flags=tuple(flags)))

    def forget(self) -> dict[str, Any]:
        """Files that were refused or are in doubt are wanted no more; what is shown stays."""
        with self._opening:
            if self._readings is not None:
                self._let_go(self._next, self._shown)
                self._next = None
            return {}

    @property
    def _latest(self) -> Opened:
        return self._next or self._shown

    def _open(self, files: Opened, more: bool = False) -> dict[str, Any]:
        """Show files where readings come of them; else they wait, and what is shown stays."""
        readings, found = (None, {"ready": False}) if more else files.read()
        with self._lock:
            last, self._next = self._next, files
            self._let_go(last, files, self._shown)
            if readings is not None:
                self._let_go(self._shown, files)
                self._shown, self._next, self._all = files, None, readings
                self._take(readings)
        return found

    def _take(self, readings: Readings) -> None:
        """Show readings, of which nothing is known yet."""
        if self._job is not None:
            self._job.cancel()
        self._readings = readings
        self.opened += 1
        self._no_more_ahead()
        self._models = self._document = self._text = self._job = None

    def leave_out(self, rows: Sequence[int]) -> dict[str, Any]:
        """Go on without some of the readings shown, or without a list with all again; the page asks
        for a new diagnosis. Raises `InvalidInputError` where too few are left."""
        with self._lock:
            now, whole = self._readings, self._all
            if now is None or whole is None:
                raise NotNow(_NOTHING)
            if not rows:
                self._take(whole)
                return {}
            if not all(0 <= row < len(now) for row in rows):
                raise InvalidInputError(f"rows: expected indices below {len(now)}")
            mask = np.ones(len(now), dtype=bool)
            mask[list(rows)] = False
            kept = now.select(mask)
            stop_if_few(now.source, kept)
            out = whole.line[~np.isin(whole.line, kept.line)].tolist()
            told = f"{len(out)} of {len(whole)} readings are left out by hand: {now.place} "
            told += _stretches(out)
            self._take(replace(kept, notes=(*whole.notes, told)))
            return {}

    @staticmethod
    def _let_go(files: Opened | None, *kept: Opened) -> None:
        """Remove a table that none of the others has."""
        upload = None if files is None else files.upload
        if upload and all(k.upload is None or k.upload.path != upload.path for k in kept):
            upload.close()

    # --- the document ---

    def document(self) -> str | None:
        """The page's document as JSON; None while there is nothing to show."""
        with self._turns.first(), self._lock:
            if self._text is None and self._readings is not None:
                self._document = self._made(None)
                self._text = to_json(self._document)
            return self._text

    def _made(self, models: Models | None) -> PageDocument:
        shown = self._shown
        assert shown.case is not None
        assert shown.upload is not None
        assert self._readings is not None
        source = Source(shown.case_name, shown.upload.name, shown.case_text, shown.command)
        document = first_document(
            shown.case,
            self._readings,
            source,
            None if models is None else models.diagnosis,
            models=models,
            isolability=None if models is None else Isolability(None, _ASK_FOR_IT),
        )
        document["opened"] = self.opened
        document["data"]["left_out"] = len(self._all or ()) - len(self._readings)
        return document

    # --- the diagnosis ---

    def start(self, seed: int = 0, own: bool = False) -> dict[str, Any]:
        """Begin a diagnosis, or join the same one that is under way. Raises `NotNow` where another
        one is, or where there is nothing to diagnose.

        own: the effects of the user's own that were fitted compete with the library.
        """
        with self._lock:
            case, readings = self._shown.case, self._readings
            if case is None or readings is None:
                raise NotNow(_NOTHING)
            if self._job is not None and self._job.wanted:
                if seed != self._seed:
                    raise NotNow("a diagnosis is under way; wait for it or cancel it")
                return self._job.to_dict()

            models = self._models
            extra = models.own if own and models is not None else ()

            def work(step: Callable[[str, float], None]) -> None:
                with self._turns.rest():
                    self._diagnose((case, readings, extra), seed, step)

            self._job, self._seed = Job(work).start(), seed
            return self._job.to_dict()

    def _diagnose(
        self,
        of: tuple[Case | Drive, Readings, Sequence[OwnEffect]],
        seed: int,
        step: Callable[[str, float], None],
    ) -> None:
        """of: the case, its readings, and own effects that compete with the library."""
        from cbpt.lab.diagnosis.diagnose import diagnose
        from cbpt.page.document.models import Models

        case, readings, own = of
        diagnosis = diagnose(
            case,
            readings,
            effects=own,
            seed=seed,
            progress=lambda what, share: step(what, 0.9 * share),
        )
        step("the answer", 0.9)
        models = Models(diagnosis, readings)
        document = self._made(models)
        text = to_json(document)
        with self._lock:
            if readings is not self._readings:
                raise Cancelled
            self._no_more_ahead()
            self._models, self._document, self._text = models, document, text
            self._ahead = self._prepares(models, document)

    def isolability(self) -> dict[str, Any]:
        """What this campaign could see and tell apart, worked out when first asked for: some
        seconds, which the answer does not wait for."""
        from cbpt.page.document.campaign import campaign_isolability

        models = self._diagnosed()

        def step(what: str, share: float) -> None:
            if not self._turns.last():
                raise NotNow(_ENDING)
            if models is not self._models:
                raise NotNow("other files have been opened meanwhile")

        with self._matrix, self._turns.rest():
            document = self._document
            if document is None:
                raise NotNow(_NO_DIAGNOSIS)
            if document["reasons"].get("isolability") == _ASK_FOR_IT:
                try:
                    found, why = campaign_isolability(models.diagnosis, step)
                    step("", 1.0)
                except NotNow as error:  # nobody waits for it any more
                    return {"isolability": None, "why": str(error)}
                with self._lock:
                    document["isolability"] = found
                    del document["reasons"]["isolability"]
                    if why is not None:
                        document["reasons"]["isolability"] = why
                    if document is self._document:
                        self._text = to_json(document)
            why = document["reasons"].get("isolability")
            return {"isolability": document["isolability"], "why": why}

    def table(self) -> dict[str, Any]:
        """The table by itself and the figures of its loops, worked out when first asked for: a
        second or two, which the answer does not wait for."""
        from cbpt.page.document.loops import table_of

        models = self._diagnosed()
        with self._tables, self._turns.first():
            document = self._document
            if document is None or models is not self._models:
                raise NotNow(_NO_DIAGNOSIS)
            found: dict[str, Any] | None = document["table"]
            if found is None:
                found = table_of(document, models.diagnosis.case, models.readings)
                with self._lock:
                    document["table"] = found
                    if document is self._document:
                        self._text = to_json(document)
            return found

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
        """Where files were given: what the page asks for first. It asks for the diagnosis once its
        first plot stands, which would wait for it otherwise. Beside it, what killed workbenches
        have left is removed."""
        self.document()
        sweep()

    def join(self, seconds: float) -> bool:
        """Wait for the diagnosis; False where it has not ended by then."""
        return self._job is None or self._job.join(seconds)

    def stop(self) -> None:
        """Whatever is under way ends at its next step."""
        if not self._turns.ended:
            self._stopped_s = time.monotonic()
        self._turns.end()
        if self._job is not None:
            self._job.cancel()

    def close(self) -> None:
        """At the end: no file of ours is left, and what goes on has had `CLOSING_S` since `stop`,
        however often this is called. What takes longer ends with the process: its thread is a
        daemon."""
        self.stop()
        for work in (self._job, self._ahead):
            if work is not None:
                work.join(max(self._stopped_s + CLOSING_S - time.monotonic(), 0.0))
        for files in (self._next, self._shown):
            self._let_go(files)

    # --- further models ---

    def model(self, effects: Sequence[str]) -> str:
        """The model with some effects, as JSON; what is one switch away from it is prepared next.
        Raises `InvalidInputError`, `NotNow`."""
        ahead = self._ahead_of(effects)
        with self._turns.first():
            text = ahead.model(effects)
        ahead.around(effects)
        return text

    def shown(self, effects: Sequence[str]) -> dict[str, Any]:
        """A model is looked at that nobody had to ask for: what may follow it is prepared."""
        with self._turns.first():
            self._ahead_of(effects).around(effects)
        return {}

    def _ahead_of(self, effects: Sequence[str]) -> Ahead:
        if len(effects) > MOST_EFFECTS:
            raise InvalidInputError(f"{len(effects)} effects, expected at most {MOST_EFFECTS}")
        ahead = self._ahead
        if ahead is None:
            self._diagnosed()
            raise NotNow(_NO_DIAGNOSIS)
        return ahead

    def _prepares(self, models: Models, document: PageDocument) -> Ahead:
        """What a first switch may ask for: from the answer, or from the drive as stated."""

        def made(effects: Effects, step: Step) -> str:
            def between() -> None:
                step()
                if self._turns.ended:
                    raise NotNow(_ENDING)

            return to_json(models.choice(effects, between))

        entries = document["models"]
        known = {frozenset(entry["effects"]) for entry in entries}
        likeliest = [candidate["effect"] for candidate in document["candidates"]]
        ahead = Ahead(
            self._turns,
            made,
            known,
            lambda: [*(effect.id for effect in models.own), *likeliest],
            MOST_EFFECTS,
        )
        ahead.around(*(e["effects"] for e in entries if e["key"] == document["answer_key"]), ())
        return ahead

    def _no_more_ahead(self) -> None:
        if self._ahead is not None:
            self._ahead.end()
            self._ahead = None

    def _diagnosed(self) -> Models:
        models = self._models
        if models is None:
            raise NotNow(_NOTHING if self._readings is None else _NO_DIAGNOSIS)
        return models

    def check_own(self, entry: Mapping[str, Any]) -> dict[str, Any]:
        """Whether an own effect can be read and fitted, else what is wrong, in which field and at
        which character; notes are what may be a slip all the same."""
        from cbpt.page.workbench.own_check import own_effect_of, refusal

        try:
            effect = own_effect_of(entry)
        except (CaseError, InvalidInputError) as error:
            return {"ok": False, **refusal(error, entry), "notes": []}
        why, notes = self._why_not(effect), doubtful_names(effect)
        said = {"message": why or "", "column": None, "field": None}
        return {"ok": why is None, **said, "notes": notes}

    def _why_not(self, effect: OwnEffect) -> str | None:
        """What keeps an own effect from being fitted to the readings, where there are some."""
        from cbpt.page.workbench.own_check import why_not

        case, readings, models = self._shown.case, self._readings, self._models
        if case is None or readings is None:
            return None
        return why_not(effect, case, readings if models is None else models.diagnosis.readings)

    def fit_own(self, entry: Mapping[str, Any], effects: Sequence[str] = ()) -> str:
        """An own effect fitted, alone or with others."""
        from cbpt.page.workbench.own_check import own_effect_of

        effect = own_effect_of(entry)
        models = self._diagnosed()
        if why := self._why_not(effect):
            raise InvalidInputError(why)
        with self._turns.first():
            models.add_own(effect)
            self._ahead_of(effects).forget()
        return self.model([*(e for e in effects if e != effect.id), effect.id])

    # --- the drive ---

    def drive(
        self,
        load: Mapping[str, float],
        design: Mapping[str, float],
        effects: Sequence[str] | None = None,
    ) -> DriveSection:
        """The drive at another load, with other numbers; with the loop of a model where its effects
        are given, which is fitted to the drive as it is in the case."""
        case, readings = self._shown.case, self._readings
        if case is None or readings is None:
            raise NotNow(_NOTHING)
        models = self._models
        with self._turns.first():
            found = redrawn(case, readings, load, design)
            if models is not None and effects is not None and not design:
                found["loop"] = models.loop(effects, found["load"])
            return found

    def datasheet(self) -> str:
        """The data sheet of the drive at the load that the page shows first, as HTML."""
        from cbpt.page.datasheet import datasheet  # draws, which the start need not wait for

        case, document = self._shown.case, self._document
        if case is None or document is None:
            raise NotNow(_NOTHING)
        load = document["drive"]["load"]
        name = document["case"]["name"]
        return datasheet(case, title=name, torque_Nm=load["torque_Nm"], preload_N=load["preload_N"])

    # --- what changed ---

    def changed(self, name: str, raw: bytes) -> ChangeSection:
        """What changed from the readings shown to a table that is handed over, which is read in the
        same way. Raises `ReadingsError`, `NoSolutionError`, `NotNow`."""
        from cbpt.page.document.changed import change_section

        case, before, shown = self._shown.case, self._readings, self._shown.upload
        if case is None or before is None or shown is None:
            raise NotNow(_NOTHING)
        if isinstance(case, Drive):
            case = Case.from_toml(case.to_toml())
        name = shown_name(name, "table")
        upload = replace(Upload.of_bytes(name, raw), columns=shown.columns, sheet=shown.sheet)
        try:
            after = upload.readings(case)
            with self._turns.rest():
                return change_section(case, before, after, (shown.name, name))
        finally:
            upload.close()

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
            entry = json.loads(self.model(effects))["model"]
        if what == "csv":
            return csv_of(self._document, entry), "text/csv", f"{stem}_readings.csv"
        if what == "case":
            if entry["why_no_case"]:
                raise NotNow(f"there is no case file of this model: {entry['why_no_case']}")
            case = entry["case_text"] or self._shown.case_text
            return case, "application/toml", f"{stem}_case.toml"
        raise NotNow(f"nothing is exported as {what!r}: json, csv, case or command")

    def _command(self, effects: Sequence[str]) -> str:
        """The command line that gives the same: of a model, with the case file as exported, since
        a fit anew may end elsewhere."""
        command = self._shown.command
        return command.compare(f"{self._stem()}_case.toml") if effects else command.report

    def _stem(self) -> str:
        assert self._shown.upload is not None
        return re.sub(r"[^\w.-]+", "_", Path(self._shown.upload.name).stem) or "cbpt"


def _stretches(places: Sequence[int]) -> str:
    """Places in rising order, with those that follow each other as one stretch: 2, 4-9, 12."""
    steps = np.flatnonzero(np.diff(places) != 1) + 1
    parts = [part.tolist() for part in np.split(np.asarray(places), steps)]
    words = [f"{p[0]}-{p[-1]}" if len(p) > 1 else f"{p[0]}" for p in parts[:_MOST_PLACES]]
    return ", ".join(words) + ", ..." * (len(parts) > _MOST_PLACES)
