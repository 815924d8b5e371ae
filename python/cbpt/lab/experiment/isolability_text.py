"""What a campaign could detect and distinguish, as text and tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from textwrap import wrap

import numpy as np

from cbpt.lab.experiment.effect_changes import Form
from cbpt.lab.experiment.isolability_data import IsolabilityData, Pair
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.wording import layout
from cbpt.lab.wording.numbers import in_words, listed
from cbpt.lab.wording.phrases import counted


def lines(i: IsolabilityData) -> Iterator[str]:
    """The report, line by line."""
    rows = i.plan.rows
    u = rows.u_elastic_angle_arcsec
    assert u is not None
    runs = counted(int(rows.run_index.max()) + 1, "run")
    yield (
        f"{len(rows)} readings in {runs} of {rows.source}, "
        f"standard uncertainty {float(np.median(u)):g} arcsec"
    )
    yield from (f"Note: {note}" for note in rows.notes)
    yield ""
    if i.seen:
        yield (
            "Smallest size of each effect that a diagnosis would detect in 50 % and in 95 % of "
            "such campaigns, and the largest plausible size (at most), with the parameters of "
            "drive and rig known within their uncertainties:"
        )
        table = []
        for s in i.seen:
            rival, r = i.looks_most_like(s.effect)
            numbers = (s.smallest["even"], s.smallest["sure"], float(s.form.sizes[-1]))
            name, values = sized(s.form, numbers)
            most = f"{rival} ({r:.3f})" if rival and r is not None else ""
            table.append([s.label, name, *values, most])
        headers = ["effect", "parameter", "in 50 %", "in 95 %", "at most", "most similar effect"]
        yield layout.table(headers, table)
    for effect, why in i.unseen.items():
        yield f"{effect}: {why}"
    for kind in (_twins, _not_here, _above):
        told = list(kind(i))
        if told:
            yield ""
            yield from told
    apart = sum(p.verdict == "apart" for p in i.pairs)
    if i.pairs:
        yield ""
        yield (
            f"{apart} of {len(i.pairs)} pairs of effects are told apart at every size of the "
            "effect at which it is detected."
        )


def sized(form: Form, sizes: Sequence[float | None]) -> tuple[str, list[str]]:
    """The parameter that is the size of a form, with its unit, and its value at each size."""
    effect, variant = form.variant.effect, form.variant
    name = "spread_m" if variant.spread else variant.sizes[0]
    label, values = name, []
    for size in sizes:
        if size is None:
            values.append("never")
            continue
        several = len(variant.sizes) > 1 and not variant.spread
        # Of components of one amplitude the direction is but an example.
        value = size if several else form.values(size)[name]
        label, text = in_words((effect, name), value, None)
        values.append(text)
    for part in ("_sine", "_cosine"):
        label = label.replace(part, "")
    return label.replace("cosine", "amplitude"), values


def _twins(i: IsolabilityData) -> Iterator[str]:
    pairs = [p for p in i.pairs if p.verdict == "twins"]
    if pairs:
        yield "Pairs that no reading of this rig can distinguish:"
    for p in pairs:
        decided = [f"{k} = {i.priors[e]:.3g}" for e, k in PRIORS.items() if k in p.decided_by]
        by = (
            f": only the stated uncertainty distinguishes them ({', '.join(decided)})"
            if decided
            else ""
        )
        yield from _wrapped(f"{p.effects[0]} and {p.effects[1]}{by}")


def _not_here(i: IsolabilityData) -> Iterator[str]:
    pairs = [p for p in i.pairs if p.verdict == "not_here"]
    if pairs:
        yield "Pairs that this plan does not distinguish at any plausible size:"
    for p in pairs:
        yield from _wrapped(_sides(i, p))


def _above(i: IsolabilityData) -> Iterator[str]:
    pairs = [p for p in i.pairs if p.verdict == "above"]
    if not pairs:
        return
    yield (
        "Pairs that this plan distinguishes only if they are larger than the smallest size "
        "detected:"
    )
    table = [
        [
            *(_from(i, e, size) for e, size in zip(p.effects, p.above, strict=True)),
            f"{p.correlation:.4f}",
        ]
        for p in sorted(pairs, key=lambda p: -p.correlation)
    ]
    yield layout.table(["one", "other", "correlation"], table)


def _sides(i: IsolabilityData, p: Pair) -> str:
    """From which size each is distinguished from the other."""
    parts = [_from(i, e, size) for e, size in zip(p.effects, p.above, strict=True)]
    return f"{listed(parts)}; correlation {p.correlation:.4f}"


def _from(i: IsolabilityData, effect: str, size: float | None) -> str:
    name, (value,) = sized(i.effect(effect).form, [size])
    return f"{effect} at no size" if size is None else f"{effect} with {name} >= {value}"


def _wrapped(text: str) -> list[str]:
    return wrap(text, layout.prose_width(), initial_indent="  ", subsequent_indent="    ")
