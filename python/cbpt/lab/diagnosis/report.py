"""The answer in words and tables, for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from textwrap import wrap
from typing import Any

from cbpt.errors import Say, said
from cbpt.lab.diagnosis.alternatives import unseen
from cbpt.lab.diagnosis.deciding_runs import why_no_run
from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.fit_text import moved_numbers, parameter_words, prior_of
from cbpt.lab.diagnosis.noise_statement import noise_floor, statement
from cbpt.lab.diagnosis.sentence import Say as Telling
from cbpt.lab.diagnosis.sentence import sentence
from cbpt.lab.diagnosis.unexplained import shape_of
from cbpt.lab.diagnosis.why import Why
from cbpt.lab.diagnosis.why import sentence as sentence_of_rival
from cbpt.lab.experiment.candidates import BOTH_WAYS
from cbpt.lab.inference.residuals import zeros_out
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.scan import label_of as label_of_region
from cbpt.lab.wording import layout
from cbpt.lab.wording.names import called, columns_in_words, number_called, scatter_from
from cbpt.lab.wording.numbers import ARCSEC, AngleUnit, listed, percent, probability, rounded

NO_EFFECT = "no effect"
"""The combination without any."""
_MOST_COMBINATIONS, _MOST_SIZES = 6, 3
"""Combinations in the table, and those whose sizes are listed."""


def lines(
    d: DiagnosisData,
    document: Mapping[str, Any],
    rivals: Sequence[Why],
    say: Say,
    angle: AngleUnit = ARCSEC,
) -> Iterator[str]:
    """The report, line by line; `document` is the answer as plain values, `rivals` are what it is
    held against."""
    kind = d.competition.campaign.drive.kind
    yield f"{len(d.readings)} readings of {d.readings.source}"
    yield from (f"Note: {angle.retold(said(note, say))}" for note in d.notes)
    yield ""
    yield from wrap(sentence(d, Telling(angle=angle)), layout.prose_width())
    yield from _probabilities(document)
    yield from _remains(document["remains"], angle)
    moved = moved_numbers(d.after, d.competition.campaign)
    if moved:
        text = f"Parameters of drive and rig changed by the fit: {moved}."
        yield from wrap(text, layout.prose_width())
    for number in document["moved"]:
        if number["could_be"]:
            other = listed([called(effect, kind) for effect in number["could_be"]], "or")
            yield from wrap(
                f"The change of {number_called(number['number'], kind)} could also be caused by "
                f"{other}.",
                layout.prose_width(),
            )
    if not d.verdict.effects and not d.verdict.rivals and d.verdict.lack_of_fit is None:
        yield from _unseen(d, angle)
    yield from wrap(statement(d, angle), layout.prose_width())
    joint = sum(r.number not in d.verdict.effects for r in d.verdict.rests_on) > 1
    together = ", with the other parameters within their uncertainties" if joint else ""
    for r in d.verdict.rests_on:
        own = r.number in d.verdict.effects
        if d.verdict.names and abs(r.needed_shift_sigma) > 2 and not own:
            name = number_called(r.number, kind)
            yield from wrap(
                f"This depends on the stated uncertainty of {name} "
                f"({prior_of(r.number, r.prior)}): it would have to be off by "
                f"{abs(r.needed_shift_sigma):.0f} standard uncertainties to explain the readings"
                f"{together}.",
                layout.prose_width(),
            )
    run = document["next_run"]
    yield from _next(d, document)
    if document["unknown"]:
        yield from _unknown(d, document["unknown"], run, angle)
    yield from _combinations(d, document["combinations"], angle)
    yield from _why(d, document, rivals, angle)
    yield from _ladder(d, angle)
    yield from _ranking(d, document["ranking"][:6], angle)
    where = document["where"]
    if where:
        yield ""
        yield "Where the model of the case disagrees with the readings:"
        for region in where[:4]:
            yield f"  {_region(region, angle)}"


def _probabilities(document: Mapping[str, Any]) -> Iterator[str]:
    """The two probabilities of an answer, each with what it is of."""
    v, best = document["verdict"], document["combinations"][0]
    chance = probability(best["probability"])
    label = label_of(best)
    exactly = f"{label}{' and nothing else' * (label != NO_EFFECT)}: {chance}"
    if v["kind"] == "undecided":
        text = f"Probability of the most probable combination, {exactly}."
    else:
        holds = probability(v["probability"])
        text = f"Probability that the answer holds: {holds}; of exactly {exactly}."
    yield from wrap(text, layout.prose_width())


def label_of(combination: Mapping[str, Any]) -> str:
    """The effects of a combination."""
    unnamed = ["an effect without a name"] if combination["unnamed"] else []
    return together([*combination["effects"], *unnamed])


def together(effects: Sequence[str]) -> str:
    """Effects of one set in words."""
    return " + ".join(effects) or NO_EFFECT


def _remains(rest: Mapping[str, Any] | None, angle: AngleUnit) -> Iterator[str]:
    """What is left after the answer, against what readings scatter by."""
    if rest is None:
        return
    share = rest["share_of_misfit"]
    part = "" if share is None else f", {percent(share)} of the squared misfit"
    scatter = ""
    source = scatter_from(rest["expected_from"])
    if rest["expected_arcsec"] is not None and source:
        scatter = f"; readings scatter by {angle.text(rest['expected_arcsec'])} ({source})"
    text = (
        f"What remains: {angle.text(rest['rms_arcsec'])} rms{part}; it depends on "
        f"{columns_in_words(rest['depends_on'])}{scatter}."
    )
    yield from wrap(text, layout.prose_width())


def _combinations(
    d: DiagnosisData, found: Sequence[Mapping[str, Any]], angle: AngleUnit
) -> Iterator[str]:
    """The sets of effects that the readings leave, each with its own errors and sizes."""
    yield ""
    yield (
        f"Combinations of effects that make up {100 * RULES.certain:.0f} % of the probability, "
        "each with its own error:"
    )
    yield _table(
        ["effects", "probability", *_errors(angle)],
        [
            [
                label_of(c),
                probability(c["probability"]),
                angle.number(c["rmse_arcsec"]),
                angle.number(c["held_out_rmse_arcsec"]),
                rounded(c["chi2_per_dof"]),
            ]
            for c in found[:_MOST_COMBINATIONS]
        ],
    )
    more = len(found) - _MOST_COMBINATIONS
    if more > 0:
        yield f"  and {more} less probable"
    for c in found[:_MOST_SIZES]:
        sizes = "; ".join(f"{e}: {_sizes(d, e, p, angle)}" for e, p in c["parameters"].items() if p)
        if sizes:
            yield from _wrapped(f"{label_of(c)}: {sizes}" if len(c["effects"]) > 1 else sizes)


def _why(
    d: DiagnosisData, document: Mapping[str, Any], rivals: Sequence[Why], angle: AngleUnit
) -> Iterator[str]:
    """The answer against each rival."""
    if rivals:
        yield ""
        yield f"Why {label_of(document['combinations'][0])}, and not:"
    for why in rivals:
        yield from _wrapped(sentence_of_rival(d, why, angle))


def _ladder(d: DiagnosisData, angle: AngleUnit) -> Iterator[str]:
    """The error after each step of the model."""
    yield ""
    floor, of = noise_floor(d)
    noise = f"the noise floor {of}" if floor is None else f"noise {angle.text(floor)}"
    yield from wrap(
        "Error that is left with each step and all steps above it (the rows do not add up), in "
        f"sample and held out (cross-validation by {d.held_out_by}; {noise}); "
        f"{zeros_out(d.competition.campaign, d.noise)}:",
        layout.prose_width(),
    )
    rows = [
        [
            r.added or "as stated",
            angle.number(r.rmse_arcsec),
            angle.number(r.held_out_rmse_arcsec),
            rounded(r.chi2_per_dof),
        ]
        for r in d.ladder
    ]
    yield _table(["added to the step above", *_errors(angle)], rows)
    if d.ladder_says:
        yield from wrap(d.ladder_says, layout.prose_width())


def _ranking(
    d: DiagnosisData, ranking: Sequence[Mapping[str, Any]], angle: AngleUnit
) -> Iterator[str]:
    """Single effects with their probabilities and parameters."""
    if ranking:
        yield ""
        yield "Single effects, the most probable first (probability that it alone is missing):"
        yield _table(
            ["effect", "probability", f"held_out_{angle.symbol}", "p_value", "most similar to"],
            [
                [
                    row["effect"],
                    probability(row["probability"]),
                    angle.number(row["held_out_rmse_arcsec"]),
                    f"{row['p_value']:.3f}",
                    f"{row['rival']} ({row['rival_correlation']:.2f})" if row["rival"] else "",
                ]
                for row in ranking
            ],
        )
        for row in ranking:
            sizes = _sizes(d, row["effect"], row["parameters"], angle)
            yield from _wrapped(f"{row['effect']}: {sizes}")


def _unknown(
    d: DiagnosisData, card: Mapping[str, Any], run: Mapping[str, Any] | None, angle: AngleUnit
) -> Iterator[str]:
    """What is known of a misfit that no effect explains."""
    yield ""
    yield f"The misfit, in {angle.symbol}:"
    for line in shape_of(d, angle):
        yield from _wrapped(line)
    if not run:
        yield ""
        yield from wrap(card["measure_next"], layout.prose_width())
    if card["expression"]:
        yield ""
        yield (
            "A draft of the missing term, to be added to the case as an own effect and fitted "
            f"(held-out error with it {angle.text(card['expression_held_out_rmse_arcsec'])}):"
        )
        yield from card["effect_toml"].splitlines()


def _unseen(d: DiagnosisData, angle: AngleUnit) -> Iterator[str]:
    """What could be there all the same."""
    found = unseen(d, angle)
    if found:
        yield from wrap(
            f"Not detectable with these readings: {listed(found, 'or')}.", layout.prose_width()
        )


def _sizes(d: DiagnosisData, effect: str, parameters: Mapping[str, Any], angle: AngleUnit) -> str:
    c = d.competition.campaign
    words = (parameter_words(c, (effect, n), p, angle) for n, p in parameters.items())
    return ", ".join(map(" ".join, words))


def _errors(angle: AngleUnit) -> tuple[str, str, str]:
    """Headers of errors."""
    return f"rmse_{angle.symbol}", f"held_out_{angle.symbol}", "chi2/dof"


def _wrapped(text: str) -> list[str]:
    return wrap(text, layout.prose_width(), initial_indent="  ", subsequent_indent="    ")


def _next(d: DiagnosisData, document: Mapping[str, Any]) -> Iterator[str]:
    """The next run, or why there is none where something is open."""
    v = document["verdict"]
    if document["next_run"]:
        yield from wrap(_next_run(document["next_run"]), layout.prose_width())
    elif (v["rivals"] or v["perhaps"]) and not document["unknown"]:
        why = why_no_run(d, document)
        yield from wrap(f"{why[:1].upper()}{why[1:]}.", layout.prose_width())


def _next_run(run: dict[str, Any]) -> str:
    untold = listed(run["untold"], "or")
    rest = (
        f" No run within reach tells the most probable combination from {untold}; other "
        "knowledge, such as a drawing or a calibration, can."
        if untold
        else ""
    )
    if run["largest_gain"] < RULES.log_rival_odds:
        if run["runs"] is None:
            return (
                "No run like the previous ones would decide between the combinations below; other "
                "knowledge, such as a drawing, can."
            )
        return (
            f"No single run would decide between the combinations below. About {run['runs']} runs "
            f"like this would distinguish {listed(run['separates'])}: {_load(run)}.{rest}"
        )
    return f"A run that would distinguish {listed(run['separates'])}: {_load(run)}.{rest}"


def _load(run: Mapping[str, Any]) -> str:
    return (
        f"preload {run['preload_N']:g} N, input angle {run['input_angle_deg']:g} deg, torque to "
        f"{_ends(run)} N m ({run['direction']})"
    )


def _ends(run: Mapping[str, Any]) -> str:
    """How far the torque of a run goes."""
    both = run["direction"] == BOTH_WAYS
    return f"+-{abs(run['torque_Nm']):g}" if both else f"{run['torque_Nm']:g}"


def _region(region: dict[str, object], angle: AngleUnit) -> str:
    ranges, regime = region["region"], region["regime"]
    assert isinstance(ranges, dict)
    where = label_of_region(ranges, None if regime is None else str(regime))
    return (
        f"{where}: {100 * float(str(region['share_of_misfit'])):.0f} % of the misfit, "
        f"bias {angle.text(float(str(region['bias_arcsec'])))} "
        f"(p-value {float(str(region['p_value'])):.3f})"
    )


def _table(headers: list[str], rows: list[list[str]]) -> str:
    return layout.table(headers, rows)
