"""The page's document, typed: `page_document` makes a `PageDocument`; its parts stand here.

    PageDocument    all of it; the parts follow in its order
    Choice          what the workbench adds when a further set of effects is fitted

`web/types.d.ts`, which the page's modules are checked against, is made from this file by
`python -m cbpt.page.document.typescript`. Angles are arcsec, other units stand in the names; arrays
run over the rows of the table, in the order of the readings; None (null) is "not there", and
`PageDocument.reasons` says why. Parts that the lab documents elsewhere (the answer, next_run) are
mappings here.
"""

from __future__ import annotations

from typing import Any, Literal, NotRequired, TypedDict

from cbpt.page.document.drive_types import Column, DriveSection, Loop

Branch = Literal["up", "down", "none"]
"""The way of the torque."""
Role = Literal["stated", "refitted", "answer", "rival", "candidate", "unknown", "own"]
"""What a model is to the answer."""
Ends = tuple[float, float]


HasClass = TypedDict("HasClass", {"class": str})
"""What an effect acts through, or that it is a number of the drive."""


class Parameter(TypedDict):
    """One parameter of an effect, in the unit that people read."""

    effect: str
    name: str
    value: float
    u: float | None
    unit: str
    """Empty where the name ends with it."""
    value_SI: float
    name_SI: str
    at_bound: bool
    why_no_u: str | None
    text: str
    """The name, and the value with its uncertainty and unit."""
    value_text: str
    """The value with its uncertainty and unit."""


class FittedNumber(TypedDict):
    """A number of drive or rig, which moves within its stated uncertainty."""

    number: str
    stated: float
    prior: float
    value: float
    u: float | None
    shift_sigma: float


class Rung(TypedDict):
    """One step of the ladder."""

    added: str
    label: str
    key: str
    effects: list[str]
    in_sample_arcsec: float
    held_out_arcsec: float | None
    chi2_per_dof: float | None


class Model(TypedDict):
    """One model of the readings: stated, refitted, or a set of effects that was fitted."""

    key: str
    """The effects joined by +; stated, refitted, unknown."""
    role: Role
    label: str
    effects: list[str]
    model_arcsec: Column
    residual_arcsec: Column
    """Measured less model, with the zeros in the model."""
    rmse_arcsec: float | None
    held_out_rmse_arcsec: float | None
    chi2_per_dof: float | None
    zero_arcsec: float | None
    parameters: list[Parameter]
    numbers: list[FittedNumber]
    probability: float | None
    tell_tale: str
    signature_arcsec: Column | None
    """What it adds to the drive as stated."""
    converged: bool
    """False: the search did not end; there is neither an uncertainty nor a held-out error."""
    case_text: str | None
    """The case with effects and refitted numbers in it, as `cbpt fit --out` writes it; null for the
    drive as stated, which is `case.text`, and where why_no_case says why."""
    why_no_case: str | None
    loop: Loop | None
    """Of the drive at its load; null where there is none."""
    ladder: NotRequired[list[Rung]]
    """The page keeps the steps that lead to a further model with it."""


class Choice(TypedDict):
    """A further set of effects, fitted when asked for."""

    model: Model
    curves: list[Column | None]
    """In the order of `PageDocument.curves`."""
    ladder: list[Rung]


class Product(TypedDict):
    name: str
    version: str


class CaseFile(TypedDict):
    name: str
    text: str
    """TOML."""
    sha256: str
    kind: str
    """ball_drive or torsion_spring."""


class Data(TypedDict):
    """The table of readings."""

    name: str
    rows: int
    sha256: str
    notes: list[str]
    settings: list[str]
    place: str
    """line or row: what the readings are counted by."""
    left_out: NotRequired[int]
    """Readings that somebody has left out in the workbench."""


class Head(TypedDict):
    """What was measured, on what, by whom; null where nobody said it."""

    drive: str
    measured: str
    rig: str | None
    author: str | None
    date: str | None


class ReadingColumns(TypedDict):
    """The readings as columns."""

    row: list[int]
    run: list[str | int | float]
    run_index: list[int]
    torque_Nm: list[float]
    preload_N: list[float] | None
    preload_step: list[str | int | float] | None
    input_angle_deg: Column | None
    time_s: Column | None
    temperature_degC: Column | None
    cycle: Column | None
    branch: list[Branch]
    level: list[int]
    """Index into `data.settings`."""
    measured_arcsec: list[float]
    """Less the offset of its run, so that runs lie on top of each other."""
    zero_arcsec: list[float]
    """The offset of the run: with it the angle is as it was read."""
    u_arcsec: Column | None
    regime: list[int | None]
    """Index into `regimes`."""
    used: list[bool]
    """Whether the diagnosis judged it."""
    kept: list[bool]
    """False: it lies far off and counts less."""


class MapColumn(TypedDict):
    """A column that varies, over which a residual can be mapped."""

    key: str
    label: str
    unit: str
    kind: Literal["number", "angle", "category"]


class Likely(TypedDict):
    """An effect that is likely, but neither certain nor one of a group of rivals."""

    effect: str
    label: str
    probability: float


class Combination(TypedDict):
    """A set of effects that the readings leave, with its own numbers."""

    label: str
    key: str | None
    """Of its model; null where something without a name is part of it."""
    effects: list[str]
    probability: float
    rmse_arcsec: float
    held_out_arcsec: float
    chi2_per_dof: float


class RivalGroup(TypedDict):
    """Readings that share a value or a range of a column."""

    label: str
    readings: int
    delta_chi2: float


class RivalColumn(TypedDict):
    """Chi-squared of a rival less that of the answer, by the values of a column."""

    label: str
    decides: bool
    """Whether a few values of it make up most of the difference."""
    groups: list[RivalGroup]


class Rival(TypedDict):
    """What the answer is held against."""

    label: str
    effects: list[str]
    log_odds: float
    delta_chi2: float | None
    other_log_odds: float | None
    sentence: dict[str, str]
    """By unit of angle."""
    by: list[RivalColumn]


class Remains(TypedDict):
    """What is left after the answer, against what readings scatter by."""

    rms_arcsec: float
    share_of_misfit: float | None
    depends_on: str
    expected_arcsec: float | None
    expected_from: str | None


class RestsOn(TypedDict):
    """A number of drive or rig without whose stated uncertainty another answer were as good."""

    label: str
    prior: str
    """Its stated uncertainty."""
    needed_shift_sigma: float


class Candidate(HasClass):
    """An effect that could be missing; the likeliest stands first. Before them stand numbers that
    the answer names without ranking them (nulls)."""

    effect: str
    label: str
    key: str
    """Of its model; a number that is the answer is part of `refitted`."""
    probability: float | None
    p_value: float | None
    surviving_fraction: float | None
    rival: str | None
    rival_correlation: float | None
    in_answer: bool
    is_rival: bool
    perhaps: float | None
    """Probability that it is at work, where the answer says so."""
    moved: str | None
    """How far a number that is the answer is off."""
    tell_tale: str
    equation: str


class LibraryEffect(HasClass):
    """An effect that there is for this kind of reducer."""

    effect: str
    label: str
    port: str
    tell_tale: str
    equation: str
    source: str
    why_not: str | None
    """Why these readings cannot show it."""


class Loose(TypedDict):
    below: float
    """Share of the in-sample error."""
    says: str
    """What a smaller held-out error means."""


class Ladder(TypedDict):
    rungs: list[Rung]
    stop: int
    """Index of the answer's rung; of an unknown answer, of the best of the library."""
    stop_says: str | None
    held_out_by: str
    loose: Loose


class Region(TypedDict):
    """A region of the readings in which the drive as stated fails."""

    label: str
    region: dict[str, Ends]
    regime: str | None
    readings: int
    share_of_misfit: float
    bias_arcsec: float
    excess_arcsec: float
    p_value: float


class Where(TypedDict):
    regions: list[Region]
    of: str
    """Key of the model."""


class Line(TypedDict):
    """Where a line is drawn: one for each setting of the rig and each way of the torque."""

    label: str
    level: int
    preload_N: float | None
    branch: Branch
    torque_Nm: Column


class Curve(Line):
    angle_arcsec: dict[str, Column | None]
    """By key of the model."""


class OwnParameter(TypedDict):
    """What was typed stands as it was typed where it is no number, and the check says so."""

    name: str
    unit: str
    start: float | str | None
    min: NotRequired[float | str | None]
    max: NotRequired[float | str | None]


class OwnEffect(TypedDict):
    """An effect of the user's own."""

    id: str
    port: str
    expression: str
    parameters: list[OwnParameter]
    toml: NotRequired[str]


class Variable(TypedDict):
    name: str
    meaning: str


class Port(TypedDict):
    key: str
    meaning: str


class Own(TypedDict):
    """What an editor of own effects needs."""

    draft: OwnEffect | None
    variables: list[Variable]
    ports: list[Port]


class CommandWords(TypedDict):
    """Parts of a command line on these files, each quoted for a shell."""

    case: str
    data: str
    reading: str
    """Flags that say how the table is read; empty where there are none."""


class SentencePart(TypedDict):
    """A part of the sentence of the answer."""

    text: str
    aside: bool
    """Whether it stands in parentheses: the numbers that were found."""


class ChangedNumber(TypedDict):
    """A number that changed, with its uncertainty as text."""

    effect: str
    number: str
    before: str
    after: str
    direction: str
    """up, down, new or gone."""
    probability: float


class UnchangedNumber(TypedDict):
    effect: str
    number: str
    value: str


class MeasuredLevel(TypedDict):
    """One of the tables that were compared."""

    name: str
    readings: int
    rmse_arcsec: float
    u_arcsec: float
    """Scatter of a typical reading."""
    run: list[int]
    torque_Nm: Column
    elastic_angle_arcsec: Column


class OpenChange(TypedDict):
    """What may have changed, and why it is not told as changed."""

    effect: str
    probability: float
    why: str


class MeasuredLoops(TypedDict):
    """The loops of one amplitude as they were measured, at both levels."""

    amplitude_Nm: float
    width_arcsec: list[float]
    """At zero torque."""
    u_arcsec: list[float | None]


class NumberByItself(TypedDict):
    """A number as each level has it if nothing is shared, as text."""

    effect: str
    number: str
    values: list[str]


class ChangeSection(TypedDict):
    """What changed between the readings shown and a second table."""

    kind: str
    """changed, nothing or undecided."""
    headline: str
    rest: str
    """What belongs to the headline; may be empty."""
    probability: float
    changed: list[ChangedNumber]
    open: list[OpenChange]
    unchanged: list[UnchangedNumber]
    loops: list[MeasuredLoops]
    by_itself: list[NumberByItself]
    levels: list[MeasuredLevel]
    effects: list[str]
    """Fitted at both levels."""
    remains_arcsec: float | None
    notes: list[str]


class PageDocument(TypedDict):
    """Every number on the page."""

    opened: NotRequired[int]
    """Which of the files that a workbench has shown; a report has no such number."""
    schema: str
    product: Product
    case: CaseFile
    data: Data
    head: Head
    command: str
    """The command line that makes this report."""
    command_words: CommandWords
    answer: Any
    """What `cbpt diagnose --json` writes, or null before a diagnosis."""
    sentence: dict[str, list[SentencePart]]
    """The sentence of the answer by unit of angle; empty before a diagnosis."""
    u_says: dict[str, str]
    """What the uncertainty of a reading is, by unit of angle."""
    why: list[Rival]
    """The answer against each rival."""
    answer_key: str | None
    """Key of the model that the answer offers; null where none explains the readings."""
    perhaps: list[Likely]
    combinations: list[Combination]
    """Those that make up 95 % of the posterior, the most probable first."""
    remains: Remains | None
    rests_on: list[RestsOn]
    undecided: str | None
    """Why the readings do not decide; null where they do."""
    table: Any
    """`checks` of `cbpt preflight` and the figures of `loops`; null before a diagnosis."""
    readings: ReadingColumns
    regimes: list[str]
    """Names of the contact regimes."""
    regimes_full: list[bool]
    """Of each regime, whether all meshing points carry in it."""
    columns: list[MapColumn]
    models: list[Model]
    candidates: list[Candidate]
    library: list[LibraryEffect]
    ladder: Ladder | None
    where: Where | None
    curves: list[Curve]
    curves_mean_over: list[str]
    """What differs between the readings of one point of a curve: it shows the mean over that."""
    own: Own
    noise: Any
    """`answer.noise` with noise_floor_arcsec and noise_floor_of: what it was taken from."""
    next_run: Any
    """`answer.next_run`."""
    isolability: Any
    """What `cbpt isolability` says of this campaign, with the sizes that are shown."""
    drive: DriveSection
    unit: str
    """Unit of angle in which a report is opened."""
    units: dict[str, float]
    """Units of angle on the page, each with its size in arcsec."""
    units_of_keys: dict[str, str]
    """How the unit in which a key ends is written: N m for Nm of `torque_Nm`."""
    reasons: dict[str, str]


__all__ = ["Choice", "Column", "PageDocument"]
