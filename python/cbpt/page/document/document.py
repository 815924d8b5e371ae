"""The page's document: every number on the page, in the report as in the workbench, comes from it.

    page_document   a case, its readings and what was found -> one JSON-able dict, `SCHEMA`
    Source          names and texts of the files, as the document tells them
    named           readings without the folder that they come from

Angles are arcsec, other units stand in the names; arrays run over the rows of the table, in the
order of the readings; null is "not there", and `reasons` says why.

    schema          "cbpt-page-1"
    product         {name, version}
    case            {name, text (TOML), sha256, kind: ball_drive | torsion_spring}
    data            {name, rows, sha256, notes [text], settings [text], place: line | row}
    command         the command line that makes this report
    answer          what `cbpt diagnose --json` writes, or null before a diagnosis
    answer_key      key of the model that the answer offers; null where none explains the readings
    readings        columns: row, run, run_index, torque_Nm, preload_N, preload_step,
                    input_angle_deg, time_s, temperature_degC, cycle, branch (up | down | none),
                    level (index into data.settings), measured_arcsec, u_arcsec, regime (index into
                    `regimes`), used (was judged), kept (false: lies far off and counts less)
    regimes         names of the contact regimes
    columns         [{key, label, unit, kind: number | angle | category}]: what maps can be drawn
                    over, those that vary
    models          [entry]: stated, refitted, then every set of effects that was fitted
      key           effects joined by +; stated, refitted, unknown
      role          stated | refitted | answer | rival | candidate | unknown | own
      label, effects [id], model_arcsec, residual_arcsec (measured less model, zeros in the model),
      rmse_arcsec, held_out_rmse_arcsec, chi2_per_dof, zero_arcsec, probability, tell_tale,
      signature_arcsec (what it adds to the drive as stated), converged (false: the search was not
      ended, and neither an uncertainty nor an error held out is told), case_text (the case with
      effects and refitted numbers in it, as `cbpt fit --out` writes it; null for the drive as
      stated, which is `case.text`, and where why_no_case says why),
      parameters    [{effect, name, value, u, unit, text, value_SI, name_SI, at_bound, why_no_u}]
      numbers       [{number, stated, prior, value, u, shift_sigma}]: numbers of drive and rig
    candidates      [{effect, label, class, key, probability, p_value, surviving_fraction, rival,
                    rival_correlation, in_answer, is_rival, moved, tell_tale, equation}], likeliest
                    first; before them numbers that the answer names without ranking them (nulls).
                    A number that is the answer is part of `refitted`: that is its key, and `moved`
                    says how far it is off
    library         [{effect, label, class, port, tell_tale, equation, source, why_not}]: every
                    effect there is; why_not: these readings cannot show it
    ladder          {rungs [{added, label, key, effects, in_sample_arcsec, held_out_arcsec,
                    chi2_per_dof}], stop (index of the answer's rung; of an unknown answer, of the
                    best of the library), stop_says, held_out_by, loose {below: share of the error
                    in sample, says: what a smaller one held out means}}
    where           {regions [{label, region {column: [low, high]}, regime, readings,
                    share_of_misfit, bias_arcsec, excess_arcsec, p_value}], of: key of the model}
    curves          [{label, level, preload_N, branch, torque_Nm, angle_arcsec {key: [..]}}]
    curves_mean_over [text]: what differs between the readings of one point of a curve: it shows
                    the mean over that
    own             {draft {id, port, expression, parameters [..], toml} | null,
                    variables [{name, meaning}], ports [{key, meaning}]}
    noise           answer.noise with noise_floor_arcsec and noise_floor_of: what it was taken from;
                    null where nothing adequate tells it, and why
    next_run        answer.next_run
    isolability     what `cbpt isolability` says of this campaign
    drive           see `drive`
    reasons         {key: text}
"""

from __future__ import annotations

import hashlib
import shlex
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, effect_specs, own_effect_variables
from cbpt.lab.diagnosis.fit_text import moved
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import settings
from cbpt.lab.wording.names import called, tell_tale
from cbpt.lab.wording.versions import product_version
from cbpt.page.document.curves import BRANCHES, Curves
from cbpt.page.document.plain import array, numbers
from cbpt.page.document.stated import REFITTED, STATED, UNKNOWN, key_of, stated

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.diagnosis import Diagnosis
    from cbpt.page.document.models import Models

__all__ = ["SCHEMA", "Source", "from_here", "named", "page_document"]

SCHEMA = "cbpt-page-1"
Floats = NDArray[np.float64]

PORTS = {
    "series": "adds an angle in series with the drive, rad",
    "load": "adds to the torque or to the preload",
    "reading": "adds an angle to what the instrument shows, rad",
}
"""Where an own effect may act."""
_NOT_YET = "the readings have not been diagnosed yet"
_COLUMNS = (
    ("torque_Nm", "torque", "N m", "number"),
    ("preload_N", "preload", "N", "number"),
    ("preload_step", "preload step", "", "category"),
    ("input_angle_deg", "input angle", "deg", "angle"),
    ("branch", "direction of the torque", "", "category"),
    ("time_s", "time", "s", "number"),
    ("temperature_degC", "temperature", "degC", "number"),
    ("cycle", "cycle", "", "number"),
    ("run", "run", "", "category"),
    ("measured_arcsec", "elastic angle", "arcsec", "number"),
)


@dataclass(frozen=True)
class Source:
    """What the document tells of its files, and the command line that makes it."""

    case_name: str
    data_name: str
    case_text: str = ""
    command: str = ""

    @classmethod
    def of_files(cls, case: str, data: str, case_text: str, *flags: str) -> Source:
        """Of files on disk."""
        words = ["cbpt", "report", from_here(case), from_here(data), *flags]
        names = PurePath(case).name, PurePath(data).name
        return cls(*names, case_text, shlex.join([*words, "--out", "report.html"]))


def from_here(path: str) -> str:
    """A file as a command line names it on a page that may be sent on: from where it is run, and
    without what lies above that."""
    here = Path.cwd()
    file = Path(path)
    if not file.is_absolute():
        return path
    return str(file.relative_to(here)) if file.is_relative_to(here) else file.name


def as_word(name: str) -> str:
    """A file's name in a command line, never taken for an option."""
    return f"./{name}" if name.startswith("-") else name


def named(readings: Readings, path: str, name: str) -> Readings:
    """Readings of a file by its name alone: where it lies is nobody else's business."""
    return replace(readings, source=readings.source.replace(path, name, 1))


def page_document(
    case: Case | Drive,
    readings: Readings,
    source: Source,
    diagnosis: Diagnosis | None = None,
    *,
    models: Models | None = None,
    isolability: Mapping[str, Any] | None = None,
    reasons: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """The document; without a diagnosis the readings beside the drive as stated.

    models: of the diagnosis, where they are at hand. isolability: the document of the campaign.
    reasons: why something is not there, by key.
    """
    from cbpt.page.document.drive import drive_section

    told = dict(reasons or {})
    if diagnosis is None:
        entry, _, regimes = stated(case, readings)
        entries = [entry]
        found = Found()
        lacking = ("answer", "answer_key", "candidates", "ladder", "where", "noise")
        told |= dict.fromkeys(lacking, _NOT_YET)
    else:
        from cbpt.page.document.models import Models

        models = models or Models(diagnosis, readings)
        entries, regimes = list(models.entries()), models.regimes()
        found = Found(diagnosis, models)
    if isolability is None:
        told.setdefault("isolability", _NOT_YET)
    answer = found.answer
    if answer is not None and found.key is None:
        told["answer_key"] = "no effect of the library explains these readings"
    if answer is None:
        told.setdefault("next_run", _NOT_YET)
    elif answer["next_run"] is None:
        told.setdefault("next_run", _why_no_run(answer))
    bare = case if isinstance(case, Drive) else case.drive
    text = source.case_text or case.to_toml()
    _, names = settings(readings)
    return {
        "schema": SCHEMA,
        "product": {"name": "CBPT", "version": product_version()},
        "case": {
            "name": source.case_name,
            "text": text,
            "sha256": hashlib.sha256(text.encode()).hexdigest(),
            "kind": bare.kind,
        },
        "data": {
            "name": source.data_name,
            "rows": len(readings),
            "sha256": readings.sha256,
            "notes": list(answer["notes"] if answer else readings.notes),
            "settings": names,
            "place": readings.place,
        },
        "command": source.command,
        "answer": answer,
        "answer_key": found.key,
        "readings": columns_of_readings(readings, regimes, found),
        "regimes": list(dict.fromkeys(name for name in regimes if name)),
        "columns": list(_mapped(readings)),
        "models": entries,
        "candidates": list(found.candidates()),
        "library": list(library(case, found)),
        "ladder": found.ladder(entries),
        "where": found.where(),
        **curves_of(readings, entries),
        "own": own_section(answer),
        "noise": found.noise(),
        "next_run": answer["next_run"] if answer else None,
        "isolability": isolability,
        "drive": drive_section(case, readings),
        "reasons": told,
    }


# --- readings -----------------------------------------------------------------------------


def columns_of_readings(readings: Readings, regimes: Sequence[str], found: Found) -> dict[str, Any]:
    """The table as columns."""
    places = {name: i for i, name in enumerate(dict.fromkeys(n for n in regimes if n))}
    levels, _ = settings(readings)
    step = readings.preload_step
    return {
        "row": readings.line.tolist(),
        "run": readings.run.tolist(),
        "run_index": readings.run_index.tolist(),
        "torque_Nm": numbers(readings.torque_Nm),
        "preload_N": numbers(readings.preload_N),
        "preload_step": None if step is None else step.tolist(),
        "input_angle_deg": numbers(readings.input_angle_deg),
        "time_s": numbers(readings.time_s),
        "temperature_degC": numbers(readings.temperature_degC),
        "cycle": numbers(readings.cycle),
        "branch": [BRANCHES[way] for way in readings.direction().tolist()],
        "level": levels.index.tolist(),
        "measured_arcsec": numbers(readings.elastic_angle_arcsec),
        "u_arcsec": numbers(readings.u_elastic_angle_arcsec),
        "regime": [places.get(name) for name in regimes],
        "used": found.used(len(readings)).tolist(),
        "kept": found.kept(len(readings)).tolist(),
    }


def _mapped(readings: Readings) -> Iterator[dict[str, str]]:
    """Columns that vary, over which a residual can be mapped."""
    own: dict[str, Any] = {
        "branch": readings.direction(),
        "measured_arcsec": readings.elastic_angle_arcsec,
    }
    for key, label, unit, kind in _COLUMNS:
        values = own[key] if key in own else getattr(readings, key)
        if values is not None and len(np.unique(values)) > 1:
            yield {"key": key, "label": label, "unit": unit, "kind": kind}


def curves_of(readings: Readings, entries: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Lines through every model, and what they are means over."""
    curves = Curves(readings)
    lines = [line | {"angle_arcsec": {}} for line in curves.lines]
    for entry in entries:
        of_model = curves.of(array(entry["model_arcsec"]))
        for line, angle in zip(lines, of_model, strict=True):
            line["angle_arcsec"][entry["key"]] = angle
    return {"curves": lines, "curves_mean_over": curves.mean_over}


# --- what was found -----------------------------------------------------------------------


class Found:
    """What a diagnosis says, for the page; without one, that there is nothing to say yet."""

    def __init__(self, diagnosis: Diagnosis | None = None, models: Models | None = None) -> None:
        self.diagnosis, self.models = diagnosis, models
        self.answer = None if diagnosis is None else diagnosis.to_dict()
        self.key: str | None = None
        if diagnosis is not None and diagnosis.verdict.kind != "unknown":
            self.key = key_of(diagnosis.verdict.names)

    def used(self, n: int) -> NDArray[np.bool_]:
        """Rows that were judged."""
        return np.ones(n, dtype=bool) if self.models is None else self.models.used

    def kept(self, n: int) -> NDArray[np.bool_]:
        """False where a reading lies far off and counts less."""
        kept = np.ones(n, dtype=bool)
        looser = None if self.diagnosis is None else self.diagnosis.competition.looser
        if looser is not None:
            kept[self.used(n)] = looser <= 2.0
        return kept

    def candidates(self) -> Iterator[dict[str, Any]]:
        """The ranking, each with what a card shows."""
        if self.diagnosis is None or self.answer is None:
            return
        specs = {spec.id: spec for spec in effect_specs()}
        kind = self.diagnosis.competition.campaign.drive.kind
        verdict = self.answer["verdict"]
        rivals = {effect for group in verdict["rivals"] for effect in group}
        numbers = self.models.numbers_named if self.models else []
        off = self.numbers_off
        ranked = ("probability", "p_value", "surviving_fraction", "rival", "rival_correlation")
        unranked = [
            {
                "effect": number,
                "class": specs[number].kind,
                "in_answer": number in verdict["effects"],
                **dict.fromkeys(ranked),
            }
            for number in numbers
        ]
        for row in [*unranked, *self.answer["ranking"]]:
            effect = row["effect"]
            spec = specs.get(effect)
            yield {
                "effect": effect,
                "label": called(effect, kind),
                "class": row["class"],
                "key": REFITTED if effect in off else key_of([effect]),
                **{name: row[name] for name in ranked},
                "in_answer": effect in off or (row["in_answer"] and self.key is not None),
                "moved": moved(effect, self.diagnosis.after) if effect in off else None,
                "is_rival": effect in rivals,
                "tell_tale": tell_tale(effect, kind),
                "equation": spec.equation if spec else "",
            }

    @property
    def numbers_off(self) -> list[str]:
        """Numbers that are the answer: the refit has them, no effect stands for them."""
        v = None if self.diagnosis is None else self.diagnosis.verdict
        return [e for e in v.effects if e in PRIORS and e not in v.names] if v else []

    def ladder(self, entries: Sequence[Mapping[str, Any]]) -> dict[str, Any] | None:
        """The rungs with the models they stand for."""
        d = self.diagnosis
        if d is None:
            return None
        from cbpt.lab.diagnosis.diagnosis_data import FAR_BELOW, LOOSE

        models = {entry["key"]: entry for entry in entries}
        final = d.final_rung
        rungs: list[dict[str, Any]] = []
        have: tuple[str, ...] | None = ()
        for place, rung in enumerate(d.ladder):
            key = (STATED, REFITTED)[place] if place < 2 else UNKNOWN
            if place > 1:
                added = rung.added.split(" + ")
                have = (*have, *added) if have is not None else None
                if have is not None and tuple(sorted(have)) in d.competition.fits:
                    key = key_of(have)
                else:
                    have = None
            told: dict[str, Any] = {
                "added": rung.added,
                "label": rung.added or "as stated",
                "key": key,
                "effects": list(have) if have is not None else [],
                "in_sample_arcsec": rung.rmse_arcsec,
                "held_out_arcsec": rung.held_out_rmse_arcsec,
                "chi2_per_dof": rung.chi2_per_dof,
            }
            if have and not d.competition.fits[tuple(sorted(have))].converged:
                # The model has been searched further than the diagnosis had to.
                told["in_sample_arcsec"] = models[key]["rmse_arcsec"]
                told["held_out_arcsec"] = models[key]["held_out_rmse_arcsec"]
                told["chi2_per_dof"] = models[key]["chi2_per_dof"]
            rungs.append(told)
        stop = next(i for i, r in enumerate(d.ladder) if r is final)
        if self.numbers_off:
            # They are in the rung of the refit already; left free they are no step further.
            names = ", ".join(name.replace("_", " ") for name in self.numbers_off)
            rungs[1]["label"] = f"numbers refitted ({names})"
            rungs = [
                r
                for i, r in enumerate(rungs)
                if i <= stop or not set(r["effects"]) <= set(self.numbers_off)
            ]
        return {
            "rungs": rungs,
            "stop": stop,
            "stop_says": _stop_says(d, stop) if stop + 1 < len(rungs) else None,
            "held_out_by": d.held_out_by,
            "loose": {"below": FAR_BELOW, "says": LOOSE},
        }

    def where(self) -> dict[str, Any] | None:
        """Regions in which the drive as stated fails."""
        if self.answer is None:
            return None
        from cbpt.lab.selection.scan import label_of

        regions = []
        for region in self.answer["where"]:
            ends = {name: (low, high) for name, (low, high) in region["region"].items()}
            regions.append({"label": label_of(ends, region["regime"])} | region)
        return {"regions": regions, "of": STATED}

    def noise(self) -> dict[str, Any] | None:
        """The noise, and the error that it alone leaves."""
        if self.answer is None or self.diagnosis is None:
            return None
        from cbpt.lab.diagnosis.noise_statement import floor_of

        floor, of = floor_of(self.diagnosis)
        return {**self.answer["noise"], "noise_floor_arcsec": floor, "noise_floor_of": of}


def _stop_says(d: Diagnosis, stop: int) -> str | None:
    """Why the ladder goes no further by name; None where it goes no further at all."""
    if stop + 1 >= len(d.ladder):
        return None
    if d.verdict.pattern is not None:
        return "no effect gets further; below, a pattern without a name"
    last, more = (r.held_out_rmse_arcsec for r in d.ladder[stop : stop + 2])
    if more >= last:
        return "stop: more gains nothing held out"
    return "stop: what more gains is too little to be likelier"


def library(case: Case | Drive, found: Found) -> Iterator[dict[str, Any]]:
    """Every effect of the library that this kind of reducer can have."""
    kind = (case if isinstance(case, Drive) else case.drive).kind
    fitted = None
    if found.diagnosis is not None:
        fitted = {v.effect for v in found.diagnosis.competition.fitter.variants}
    for spec in effect_specs():
        if kind in spec.reducers and spec.id != "run_offset":
            there = fitted is None or spec.id in fitted
            yield {
                "effect": spec.id,
                "label": called(spec.id, kind),
                "class": spec.kind,
                "port": spec.port,
                "tell_tale": tell_tale(spec.id, kind),
                "equation": spec.equation,
                "source": spec.source,
                "why_not": None if there else "the table lacks a column that it depends on",
            }


def own_section(answer: Mapping[str, Any] | None) -> dict[str, Any]:
    """What an editor of own effects needs, with the draft for what is unknown."""
    unknown = answer["unknown"] if answer else None
    toml = unknown["effect_toml"] if unknown else None
    draft = None
    if toml:
        entry = tomllib.loads(toml)["effect"][0]
        parameters = [{"name": name} | p for name, p in entry.pop("parameters", {}).items()]
        draft = entry | {"parameters": parameters, "toml": toml}
    return {
        "draft": draft,
        "variables": [{"name": n, "meaning": meaning} for n, meaning in own_effect_variables()],
        "ports": [{"key": key, "meaning": meaning} for key, meaning in PORTS.items()],
    }


def _why_no_run(answer: Mapping[str, Any]) -> str:
    verdict = answer["verdict"]
    if verdict["kind"] == "unknown":
        return str(answer["unknown"]["measure_next"])
    if verdict["rivals"] or verdict["kind"] == "ambiguous":
        return "no run like those so far would decide between the rivals"
    return "the answer leaves no rivals that a further run would have to decide between"
