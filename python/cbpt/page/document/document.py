"""The page's document: every number on the page, in the report as in the workbench, comes from it.

    page_document   a case, its readings and what was found -> a `PageDocument`
    first_document  the same but for the section of the table
    Isolability     what the campaign could see, or why that is not known

What it holds is typed in `types`: `PageDocument` and its parts.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, effect_specs, own_effect_variables
from cbpt.lab.diagnosis.deciding_runs import why_no_run
from cbpt.lab.diagnosis.fit_text import moved_by, prior_of
from cbpt.lab.model.forward import REGIMES
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import settings
from cbpt.lab.selection.posterior import OFFSET
from cbpt.lab.wording.names import called, columns_in_words, number_called, scatter_from, tell_tale
from cbpt.lab.wording.numbers import AngleUnit
from cbpt.lab.wording.versions import product_version
from cbpt.page.document.curves import BRANCHES, Curves
from cbpt.page.document.head import head_of
from cbpt.page.document.plain import array, finite_numbers, numbers
from cbpt.page.document.sentence import sentences
from cbpt.page.document.source import Source
from cbpt.page.document.stated import REFITTED, STATED, UNKNOWN, free_function, key_of, stated
from cbpt.page.document.types import (
    Candidate,
    CaseFile,
    Combination,
    Curve,
    Data,
    Ladder,
    LibraryEffect,
    Likely,
    MapColumn,
    Model,
    Own,
    PageDocument,
    ReadingColumns,
    Remains,
    RestsOn,
    Rival,
    Rung,
    Where,
)
from cbpt.page.document.units import ANGLE_SIZES, at_ends

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.diagnosis import Diagnosis
    from cbpt.page.document.models import Models

__all__ = ["SCHEMA", "Isolability", "first_document", "page_document"]

SCHEMA = "cbpt-page-1"
Floats = NDArray[np.float64]

PORTS = {
    "series": "the effect adds an angle in series with the drive, rad",
    "load": "the effect adds to the torque, N m, or to the preload, N, of each reading",
    "reading": "the effect adds an angle to the reading of the instrument, rad",
}
"""Where an own effect may act."""
_NOT_YET = "the readings have not been diagnosed yet"
_COLUMNS: tuple[tuple[str, str, str, Literal["number", "angle", "category"]], ...] = (
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


class Isolability(NamedTuple):
    """What the campaign could see: its document; or None, and why there is none."""

    document: dict[str, Any] | None
    why: str | None


def page_document(
    case: Case | Drive,
    readings: Readings,
    source: Source,
    diagnosis: Diagnosis | None = None,
    *,
    models: Models | None = None,
    isolability: Isolability | None = None,
) -> PageDocument:
    """The document; without a diagnosis the readings beside the drive as stated.

    models: of the diagnosis, where they are at hand. isolability: what the campaign could see, or
    why that is not known.
    """
    document = first_document(
        case, readings, source, diagnosis, models=models, isolability=isolability
    )
    if diagnosis is not None:
        from cbpt.page.document.loops import table_of

        document["table"] = table_of(document, case, readings)
    return document


def first_document(
    case: Case | Drive,
    readings: Readings,
    source: Source,
    diagnosis: Diagnosis | None = None,
    *,
    models: Models | None = None,
    isolability: Isolability | None = None,
) -> PageDocument:
    """The same without its section of the table, which takes longer than all the rest."""
    if diagnosis is None:
        entry, _, regimes = stated(case, readings)
        entries, found = [entry], Found()
    else:
        from cbpt.page.document.models import Models

        models = models or Models(diagnosis, readings)
        entries, regimes = list(models.entries()), models.regimes()
        found = Found(diagnosis, models)
    return _document((case, readings, source), found, entries, regimes, isolability)


def _document(
    of: tuple[Case | Drive, Readings, Source],
    found: Found,
    entries: list[Model],
    regimes: Sequence[str],
    isolability: Isolability | None,
) -> PageDocument:
    """All keys. of: the case, its readings, and what they are called."""
    from cbpt.page.document.drive import drive_section

    (case, readings, source), diagnosis, answer = of, found.diagnosis, found.answer
    curves, mean_over = curves_of(readings, entries)
    names = list(dict.fromkeys(name for name in regimes if name))
    return {
        "schema": SCHEMA,
        "product": {"name": "CBPT", "version": product_version()},
        "case": _case_file(case, source),
        "data": _data(readings, source, answer),
        "head": head_of(case, readings, source),
        "command": source.command.report,
        "command_words": source.command.words(),
        "answer": answer,
        "answer_key": found.key,
        "sentence": {} if diagnosis is None else sentences(diagnosis),
        "u_says": found.u_says(),
        "why": list(found.why()),
        "perhaps": list(found.perhaps()),
        "combinations": list(found.combinations()),
        "remains": found.remains(),
        "rests_on": list(found.rests_on()),
        "undecided": answer["verdict"]["undecided"] if answer else None,
        "table": None,
        "readings": columns_of_readings(readings, regimes, found),
        "regimes": names,
        "regimes_full": [name == REGIMES[0] for name in names],
        "columns": list(_mapped(readings)),
        "models": entries,
        "candidates": list(found.candidates()),
        "library": list(library(case, found)),
        "ladder": found.ladder(),
        "where": found.where(),
        "curves": curves,
        "curves_mean_over": mean_over,
        "own": own_section(answer),
        "noise": found.noise(),
        "next_run": answer["next_run"] if answer else None,
        "isolability": isolability.document if isolability else None,
        "drive": drive_section(case, readings),
        "unit": source.angle_unit,
        "units": ANGLE_SIZES,
        "units_of_keys": at_ends(),
        "reasons": dict(_reasons(found, isolability)),
    }


def _case_file(case: Case | Drive, source: Source) -> CaseFile:
    text = source.case_text or case.to_toml()
    return {
        "name": source.case_name,
        "text": text,
        "sha256": hashlib.sha256(text.encode()).hexdigest(),
        "kind": (case if isinstance(case, Drive) else case.drive).kind,
    }


def _data(readings: Readings, source: Source, answer: Mapping[str, Any] | None) -> Data:
    return {
        "name": source.data_name,
        "rows": len(readings),
        "sha256": readings.sha256,
        "notes": list(answer["notes"] if answer else readings.notes),
        "settings": settings(readings)[1],
        "place": readings.place,
    }


def _reasons(found: Found, isolability: Isolability | None) -> Iterator[tuple[str, str]]:
    """Why something is not there, by key."""
    if found.answer is None:
        for key in ("answer", "answer_key", "candidates", "ladder", "where", "noise", "next_run"):
            yield key, _NOT_YET
    else:
        if found.key is None:
            open_ = found.answer["verdict"]["undecided"]
            why = (
                "the readings do not decide" if open_ else "no known effect explains these readings"
            )
            yield "answer_key", why
        if found.answer["next_run"] is None:
            assert found.diagnosis is not None
            yield "next_run", why_no_run(found.diagnosis, found.answer)
    if isolability is None:
        yield "isolability", _NOT_YET
    elif isolability.why is not None:
        yield "isolability", isolability.why


# --- readings -----------------------------------------------------------------------------


def columns_of_readings(readings: Readings, regimes: Sequence[str], found: Found) -> ReadingColumns:
    """The table as columns."""
    places = {name: i for i, name in enumerate(dict.fromkeys(n for n in regimes if n))}
    levels, _ = settings(readings)
    step, preload = readings.preload_step, readings.preload_N
    return {
        "row": readings.line.tolist(),
        "run": readings.run.tolist(),
        "run_index": readings.run_index.tolist(),
        "torque_Nm": finite_numbers(readings.torque_Nm),
        "preload_N": None if preload is None else finite_numbers(preload),
        "preload_step": None if step is None else step.tolist(),
        "input_angle_deg": numbers(readings.input_angle_deg),
        "time_s": numbers(readings.time_s),
        "temperature_degC": numbers(readings.temperature_degC),
        "cycle": numbers(readings.cycle),
        "branch": [BRANCHES[way] for way in readings.direction().tolist()],
        "level": levels.index.tolist(),
        "measured_arcsec": finite_numbers(readings.elastic_angle_arcsec - found.zero(readings)),
        "zero_arcsec": finite_numbers(found.zero(readings)),
        "u_arcsec": numbers(readings.u_elastic_angle_arcsec),
        "regime": [places.get(name) for name in regimes],
        "used": found.used(len(readings)).tolist(),
        "kept": found.kept(len(readings)).tolist(),
    }


def _with_unit(label: str, unit: str) -> str:
    """Preload (N); the run has no unit."""
    return f"{label} ({unit})" if unit else label


def _mapped(readings: Readings) -> Iterator[MapColumn]:
    """Columns that vary, over which a residual can be mapped."""
    own: dict[str, Any] = {
        "branch": readings.direction(),
        "measured_arcsec": readings.elastic_angle_arcsec,
    }
    for key, label, unit, kind in _COLUMNS:
        values = own[key] if key in own else getattr(readings, key)
        if values is not None and len(np.unique(values)) > 1:
            yield {"key": key, "label": label, "unit": unit, "kind": kind}


def curves_of(readings: Readings, entries: Sequence[Model]) -> tuple[list[Curve], list[str]]:
    """Lines through every model, and what they are means over."""
    curves = Curves(readings)
    lines: list[Curve] = [{**line, "angle_arcsec": {}} for line in curves.lines]
    for entry in entries:
        of_model = curves.of(array(entry["model_arcsec"]))
        for line, angle in zip(lines, of_model, strict=True):
            line["angle_arcsec"][entry["key"]] = angle
    return lines, curves.mean_over


# --- what was found -----------------------------------------------------------------------


class Found:
    """What a diagnosis says, for the page; without one, that there is nothing to say yet."""

    def __init__(self, diagnosis: Diagnosis | None = None, models: Models | None = None) -> None:
        self.diagnosis, self.models = diagnosis, models
        self.answer = None if diagnosis is None else diagnosis.to_dict()
        self.key: str | None = None
        if diagnosis is not None and diagnosis.verdict.kind not in ("unknown", "undecided"):
            self.key = key_of(diagnosis.verdict.names)

    def used(self, n: int) -> NDArray[np.bool_]:
        """Rows that were judged."""
        return np.ones(n, dtype=bool) if self.models is None else self.models.used

    def kept(self, n: int) -> NDArray[np.bool_]:
        """False where a reading lies far off and counts less."""
        kept = np.ones(n, dtype=bool)
        inflation = None if self.diagnosis is None else self.diagnosis.after.noise.inflation
        if inflation is not None:
            kept[self.used(n)] = inflation <= 2.0
        return kept

    def zero(self, readings: Readings) -> Floats:
        """The offset of the run of each reading, which is taken off what is drawn."""
        return np.zeros(len(readings)) if self.models is None else self.models.zero

    def perhaps(self) -> Iterator[Likely]:
        """Effects that are likely, with their names."""
        if self.diagnosis is None:
            return
        kind = self.diagnosis.competition.campaign.drive.kind
        for effect, chance in self.diagnosis.verdict.perhaps:
            yield {"effect": effect, "label": called(effect, kind), "probability": chance}

    def combinations(self) -> Iterator[Combination]:
        """The sets of effects that the readings leave, each with its own errors."""
        if self.answer is None:
            return
        from cbpt.lab.diagnosis.report import label_of

        for row in self.answer["combinations"]:
            named = [e for e in row["effects"] if e != OFFSET]
            yield {
                "label": label_of(row).replace("_", " "),
                "key": None if row["unnamed"] else key_of(named),
                "effects": row["effects"],
                "probability": row["probability"],
                "rmse_arcsec": row["rmse_arcsec"],
                "held_out_arcsec": row["held_out_rmse_arcsec"],
                "chi2_per_dof": row["chi2_per_dof"],
            }

    def u_says(self) -> dict[str, str]:
        """What the uncertainty of a reading is, by unit of angle."""
        if self.diagnosis is None:
            return {}
        from cbpt.lab.diagnosis.noise_statement import statement

        return {unit: statement(self.diagnosis, AngleUnit(unit)) for unit in ANGLE_SIZES}

    def why(self) -> Iterator[Rival]:
        """The answer against each rival."""
        if self.diagnosis is None or self.answer is None:
            return
        from cbpt.lab.diagnosis.report import label_of
        from cbpt.lab.diagnosis.why import sentence

        units = {column: (label, unit) for column, label, unit, _ in _COLUMNS}
        units["direction"] = units["branch"]
        for why, row in zip(self.diagnosis.why(), self.answer["why"], strict=True):
            told = {unit: sentence(self.diagnosis, why, AngleUnit(unit)) for unit in ANGLE_SIZES}
            first = {group["column"] for group in row["decides"]}
            yield {
                "label": label_of(row).replace("_", " "),
                "effects": row["effects"],
                "log_odds": row["log_odds"],
                "delta_chi2": row["delta_chi2"],
                "other_log_odds": row["other_log_odds"],
                "sentence": told,
                "by": [
                    {
                        "label": _with_unit(*units.get(column, (column, ""))),
                        "decides": column in first,
                        "groups": groups,
                    }
                    for column, groups in row["by"].items()
                ],
            }

    def remains(self) -> Remains | None:
        """What is left after the answer, in words."""
        rest = self.answer["remains"] if self.answer else None
        if rest is None:
            return None
        same = ("rms_arcsec", "share_of_misfit", "expected_arcsec")
        words = {
            "depends_on": columns_in_words(rest["depends_on"]),
            "expected_from": scatter_from(rest["expected_from"]),
        }
        return cast(Remains, {key: rest[key] for key in same} | words)

    def rests_on(self) -> Iterator[RestsOn]:
        """The stated numbers that the answer rests on, by name."""
        if self.diagnosis is None or self.answer is None:
            return
        kind = self.diagnosis.competition.campaign.drive.kind
        for row in self.answer["verdict"]["rests_on"]:
            yield {
                "label": number_called(row["number"], kind),
                "prior": prior_of(row["number"], row["prior"]),
                "needed_shift_sigma": row["needed_shift_sigma"],
            }

    def candidates(self) -> Iterator[Candidate]:
        """The ranking, each with what a card shows."""
        if self.diagnosis is None or self.answer is None:
            return
        specs = {spec.id: spec for spec in effect_specs()}
        kind = self.diagnosis.competition.campaign.drive.kind
        verdict = self.answer["verdict"]
        rivals = {effect for group in verdict["rivals"] for effect in group}
        likely = {row["effect"]: row["probability"] for row in verdict["perhaps"]}
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
        known = {row["effect"] for row in (*unranked, *self.answer["ranking"])}
        # An effect that shows beside another alone was not fitted by itself.
        together = [e for e in verdict["effects"] if e in specs and e not in {*known, *off}]
        unranked += [
            {"effect": e, "class": specs[e].kind, "in_answer": True, **dict.fromkeys(ranked)}
            for e in together
        ]
        keys = dict.fromkeys(off, REFITTED) | dict.fromkeys(together, self.key or REFITTED)
        for row in [*unranked, *self.answer["ranking"]]:
            effect = row["effect"]
            spec = specs.get(effect)
            yield {
                "effect": effect,
                "label": called(effect, kind),
                "class": row["class"],
                "key": keys.get(effect) or key_of([effect]),
                "probability": row["probability"],
                "p_value": row["p_value"],
                "surviving_fraction": row["surviving_fraction"],
                "rival": row["rival"],
                "rival_correlation": row["rival_correlation"],
                "in_answer": effect in off or (row["in_answer"] and self.key is not None),
                "moved": moved_by(effect, self.diagnosis.after) if effect in off else None,
                "is_rival": effect in rivals,
                "perhaps": likely.get(effect),
                "tell_tale": tell_tale(effect, kind),
                "equation": spec.equation if spec else "",
            }

    @property
    def numbers_off(self) -> list[str]:
        """Numbers that are the answer: the refit has them, no effect stands for them."""
        v = None if self.diagnosis is None else self.diagnosis.verdict
        return [e for e in v.effects if e in PRIORS and e not in v.names] if v else []

    def ladder(self) -> Ladder | None:
        """The rungs with the models they stand for."""
        d = self.diagnosis
        if d is None:
            return None
        from cbpt.lab.diagnosis.diagnosis_data import FAR_BELOW, LOOSE

        final = d.final_rung
        rungs: list[Rung] = []
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
            told: Rung = {
                "added": rung.added,
                "label": rung.added or "as stated",
                "key": key,
                "effects": list(have) if have is not None else [],
                "in_sample_arcsec": rung.rmse_arcsec,
                "held_out_arcsec": rung.held_out_rmse_arcsec,
                "chi2_per_dof": rung.chi2_per_dof,
            }
            rungs.append(told)
        if d.verdict.lack_of_fit is not None:
            rungs[-1]["label"] = free_function(d.verdict.lack_of_fit.columns)
        stop = next(i for i, r in enumerate(d.ladder) if r is final)
        if self.numbers_off:
            # They are in the rung of the refit already; left free they are no step further.
            names = ", ".join(name.replace("_", " ") for name in self.numbers_off)
            rungs[1]["label"] = f"parameters refitted ({names})"
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

    def where(self) -> Where | None:
        """Regions in which the model as stated disagrees with the readings."""
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
    if d.verdict.lack_of_fit is not None:
        return "no effect reduces the error further; below: a lack of fit"
    last, more = (r.held_out_rmse_arcsec for r in d.ladder[stop : stop + 2])
    if more >= last:
        return "stop: a further effect does not reduce the held-out error"
    return "stop: a further effect reduces the error too little to be more probable"


def library(case: Case | Drive, found: Found) -> Iterator[LibraryEffect]:
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
                "why_not": None if there else "the table lacks a column that the effect depends on",
            }


def own_section(answer: Mapping[str, Any] | None) -> Own:
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
