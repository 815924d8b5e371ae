"""
Mechanics of a cycloid ball planetary transmission, compiled.
"""

from _typeshed import SupportsGetItem, SupportsLenAndGetItem
from numpy import bool_, float64, int64, uint32, uint8
from numpy.typing import NDArray
from os import PathLike
from typing import Any, SupportsFloat, SupportsIndex, final

__all__ = ["Case", "Drive", "Effect", "EffectParameter", "EffectSpec", "Enclosure", "Finding", "Friction", "FrictionContact", "LargestAngle", "Misfit", "NoiseFilter", "NoisePolynomials", "OwnEffect", "PairFriction", "PairSolution", "Prediction", "Predictor", "PreloadThresholds", "Seen", "Sensitivities", "Sensitivity", "Solution", "SweepCsv", "SweepPlan", "SweepTally", "Thresholds", "Unit", "Whitener", "ball_loads", "design_number", "design_numbers", "effect_specs", "example_case", "friction_of_loads", "held_at_bounds", "is_sweep_plan", "judge_designs", "log_scale_prior", "noise_products", "own_effect_variables", "painted", "quadratic_step", "run_command_line", "search_noise", "solve_angles", "sweep_findings", "sweep_statuses", "take_out", "terminal_colour", "terminal_width", "text_table", "unit_size", "units"]

@final
class Case:
    """
    A case file: the drive and, if given, load, measurement, uncertainties and effects.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self, /) -> int: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __reduce__(self, /) -> tuple[Any, tuple[str]]: ...
    def __repr__(self, /) -> str: ...
    def costs(self, /, torque_Nm: SupportsFloat | SupportsIndex, preload_N: SupportsFloat | SupportsIndex, input_angle_deg: SupportsFloat | SupportsIndex = 0.0, coefficient: SupportsFloat | SupportsIndex | None = None, static_safety: SupportsFloat | SupportsIndex | None = None) -> tuple[str, str]:
        """
        What preload and stiffness cost under a load: text for a terminal, and the JSON document of ``cbpt friction``.
        """
    @property
    def drive(self, /) -> Drive:
        """
        The drive without the effects of the case.
        """
    @property
    def effects(self, /) -> list[Effect]:
        """
        Effects that the case adds to the drive.
        """
    @property
    def friction_between_runs(self, /) -> str:
        """
        Whether friction goes on where a run begins as the one before it ended: if both are timed by one clock
        (``by_clock``), at no run (``released``), or whatever the clocks (``carried``; ``carried_from_above`` and
        ``carried_from_below`` say from where the torque came before the first run).
        """
    @property
    def friction_coefficient(self, /) -> float:
        """
        Friction coefficient of ``[friction]``.
        """
    @staticmethod
    def from_dict(case: "dict[str, Any]") -> Case:
        """
        Makes a case from a dict with the sections and keys of a case file.
        """
    @staticmethod
    def from_file(path: str | PathLike[str]) -> Case:
        """
        Reads a case file. Raises ``CaseError`` with file, line, key, what was found and what is allowed.
        """
    @staticmethod
    def from_toml(text: str, name: str = "<text>") -> Case:
        """
        Reads a case from TOML text; ``name`` stands for the file in messages.
        """
    @property
    def input_angle_deg(self, /) -> float | None:
        """
        Input angle of ``[load]``, degrees, or ``None``.
        """
    @property
    def lever_arm_mm(self, /) -> float | None:
        """
        Lever arm of a displacement sensor, mm, or ``None``.
        """
    def nominal(self, /) -> Case:
        """
        The same case with nominal parts.
        """
    @property
    def output_inertia_kg_m2(self, /) -> float | None:
        """
        Moment of inertia at the output of ``[operation]``, kg m^2, or ``None``.
        """
    @property
    def own_effects(self, /) -> list[OwnEffect]:
        """
        The effects of the user's own among those of the case.
        """
    @property
    def preload_N(self, /) -> float | None:
        """
        Preload of ``[load]``, N, or ``None``.
        """
    @property
    def rated_torque_Nm(self, /) -> float | None:
        """
        Rated torque of ``[rating]``, N m, or ``None``.
        """
    def spreads(self, /) -> list[tuple[str, str, float]]:
        """
        Spread of the numbers of a ball drive and its load, from ``[tolerance]`` or else ``[uncertainty]``: name in SI, ``uniform``
        or ``normal``, and the limit or standard uncertainty, SI.

        Raises ``InvalidInputError`` for a spread that stands for two numbers whose values differ.
        """
    def to_toml(self, /, like: str | None = None) -> str:
        """
        The case as a file in SI units; ``from_toml`` of it gives the same case to the last bit.

        ``like`` is the text of the file that the case was made of: its comments, order and units stay, and only effects that
        are new or have other numbers are written, in the unit that stands there or the usual one; that may cost such a number one
        unit in its last place. Raises ``CaseError`` where that text is no case.
        """
    @property
    def torque_Nm(self, /) -> float | None:
        """
        Torque of ``[load]``, N m, or ``None``.
        """
    @property
    def torque_turns(self, /) -> str:
        """
        Where the torque of a table with times reverses: ``where_ramps_meet``, between readings unless every reversal meets the
        clock in the same place, ``between_readings`` also then, or ``at_readings``.
        """
    def with_effects(self, /, effects: "list[tuple[str, dict[str, float]]] | list[tuple[str | OwnEffect, dict[str, float]]]") -> Case:
        """
        The case with these effects in place of its own: ids of the library, each with parameters named as in a case file
        (``{"reference_deflection_um": 2}``), a parameter that is not given has its default; or own effects, with the values of their
        parameters. The same id of the library may stand more than once.

        Raises ``CaseError`` with key, what was found and what is allowed, and ``InvalidInputError`` for a function of Python,
        which a case cannot hold.
        """
    def with_friction_between_runs(self, /, word: str) -> Case:
        """
        The case with another ``friction_between_runs``. Raises ``InvalidInputError`` for any other word.
        """
    def with_numbers(self, /, numbers: "dict[str, float]") -> Case:
        """
        The case with other values of numbers of its drive and load, named in SI (``deceleration.ball_radius_m``).

        Raises ``InvalidInputError`` for an unknown name or an invalid value.
        """
    def with_torque_turns(self, /, word: str) -> Case:
        """
        The case with another ``torque_turns``. Raises ``InvalidInputError`` for any other word.
        """
    @property
    def zero(self, /) -> str:
        """
        Whether all runs share one zero of the angle (``common``) or each has its own (``per_run``).
        """

@final
class Drive:
    """
    A cycloid ball planetary transmission, checked and frozen; or any other reducer as a torsion spring, which has
    ``solve``, but no pairs, findings and thresholds of the preload.

    Make one with :meth:`Drive.from_file`, :meth:`Drive.from_toml` or :meth:`Drive.from_dict`; the keys are those of a
    case file.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self, /) -> int: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __reduce__(self, /) -> tuple[Any, tuple[str]]: ...
    def __repr__(self, /) -> str: ...
    def backdriving_torque_Nm(self, /, preload_N: SupportsFloat | SupportsIndex, coefficient: SupportsFloat | SupportsIndex = 0.1) -> float | None:
        """
        Torque at the output, N m, that turns a free input at every angle against the friction; ``None`` if the drive locks
        up to the torque that its preload holds.
        """
    @property
    def deceleration_ball_count(self, /) -> int:
        """
        Number of deceleration balls.
        """
    @property
    def eccentricity_m(self, /) -> float:
        """
        Eccentricity e = K r0, m.
        """
    @property
    def equal_speed_ball_count(self, /) -> int:
        """
        Number of equal-speed balls (of one row of a cross-slide).
        """
    def findings(self, /, torque_Nm: SupportsFloat | SupportsIndex | None = None, preload_N: SupportsFloat | SupportsIndex | None = None, input_angle_deg: SupportsFloat | SupportsIndex = 0.0) -> list[Finding]:
        """
        Findings about the design, the worst first.

        Parameters
        ----------
        torque_Nm, preload_N : float, optional
            A load, N m and N. With both, the contacts under this load are checked too.
        input_angle_deg : float, optional
            Angle of the input crank, degrees.

        Returns
        -------
        list of Finding
            Each with code, severity, pair, message and remedy.

        Raises
        ------
        InvalidInputError
            For an invalid load, for a torque without a preload or the reverse, and for a torsion spring.
        """
    def friction(self, /, torque_Nm: SupportsFloat | SupportsIndex, preload_N: SupportsFloat | SupportsIndex, input_angle_deg: SupportsFloat | SupportsIndex | None = None, coefficient: SupportsFloat | SupportsIndex = 0.1) -> Friction:
        """
        Friction under a load: torque at the input, efficiency, wear.

        Parameters
        ----------
        torque_Nm : float
            Resistance torque on the output, N m, of either sign.
        preload_N : float
            Axial preload, N.
        input_angle_deg : float, optional
            Angle of the input crank, degrees: every contact there. Without it, mean and ripple over a period.
        coefficient : float, optional
            Friction coefficient of the contacts.

        Returns
        -------
        Friction
            Its ``status`` says whether the load has a solution; its numbers are ``None`` if there is none.

        Raises
        ------
        InvalidInputError
            For an invalid number, and for a torsion spring.
        """
    @staticmethod
    def from_dict(case: "dict[str, Any]") -> Drive:
        """
        Makes a drive from a dict with the sections and keys of a case file, for example
        ``{"deceleration": {"ball_count": 20, "rolling_circle_radius_mm": 4, ...}, "equal_speed": {...}}``.

        Raises ``CaseError`` with key, what was found and what is allowed.
        """
    @staticmethod
    def from_file(path: str | PathLike[str]) -> Drive:
        """
        Reads the drive of a case file.

        Raises ``CaseError`` with file, line, key, what was found and what is allowed.
        """
    @staticmethod
    def from_toml(text: str) -> Drive:
        """
        Reads the drive of a case given as TOML text.

        Raises ``CaseError`` with line, key, what was found and what is allowed.
        """
    @property
    def has_parts_as_made(self, /) -> bool:
        """
        Whether the drive has tables of its parts as they were made.
        """
    @property
    def kind(self, /) -> str:
        """
        ``ball_drive`` or ``torsion_spring``.
        """
    def largest_elastic_angle(self, /, torque_Nm: SupportsFloat | SupportsIndex, preload_N: SupportsFloat | SupportsIndex) -> LargestAngle | None:
        """
        Largest elastic angle over a period of the drive at a torque (N m) and preload (N); ``None`` if some angle of
        the crank has no solution. Ctrl-C stops it.
        """
    def nominal(self, /) -> Drive:
        """
        The same drive with nominal parts.
        """
    def preload(self, /, torque_Nm: SupportsFloat | SupportsIndex, input_angle_deg: SupportsFloat | SupportsIndex | None = None) -> PreloadThresholds:
        """
        Preload that a torque (N m) needs: to hold, for continuous transmission, for zero backlash, of each pair and of
        the drive; maxima over a period, or the values at ``input_angle_deg`` if it is given.
        """
    @property
    def repetition_turns(self, /) -> int:
        """
        Turns of the input after which the drive, with its parts as they were made, stands as before.
        """
    def sensitivities(self, /, torque_Nm: SupportsFloat | SupportsIndex, preload_N: SupportsFloat | SupportsIndex, input_angle_deg: SupportsFloat | SupportsIndex = 0.0, also: SupportsGetItem[int, str] = ..., coefficient: SupportsFloat | SupportsIndex | None = None, output_inertia_kg_m2: SupportsFloat | SupportsIndex | None = None) -> Sensitivities:
        """
        Exact derivatives of the elastic angle and of the preload thresholds by every design number.

        Parameters
        ----------
        torque_Nm : float
            Torque on the output, N m.
        preload_N : float
            Axial preload, N.
        input_angle_deg : float, optional
            Angle of the input crank, degrees. The thresholds are those over a period.
        also : list of str, optional
            Names of single numbers that are otherwise combined with an equal one, such as
            ``material.ball_youngs_modulus_Pa``.
        coefficient : float, optional
            Friction coefficient. With it, friction torque, efficiency, wear and static safety at the input angle too, by central
            differences: least dissipation has kinks, and ``one_sided`` names the numbers at which the slopes to both sides differ.
        output_inertia_kg_m2 : float, optional
            Moment of inertia at the output, kg m^2, for the natural frequency beside them.

        Returns
        -------
        Sensitivities
            One entry for the elastic angle, one for each threshold, and those of friction where they were asked for.

        Raises
        ------
        InvalidInputError
            For an invalid load or an unknown name, and for a torsion spring.
        """
    def solve(self, /, torque_Nm: SupportsFloat | SupportsIndex, preload_N: SupportsFloat | SupportsIndex | None = None, input_angle_deg: SupportsFloat | SupportsIndex = 0.0) -> Solution:
        """
        Solves the drive under one load.

        Parameters
        ----------
        torque_Nm : float
            Resistance torque on the output, N m, of either sign.
        preload_N : float, optional
            Axial preload, N, above 0. A ball drive needs one; a torsion spring does not.
        input_angle_deg : float, optional
            Angle of the input crank from the line of centres, degrees.

        Returns
        -------
        Solution
            Its ``status`` says whether the load has a solution; its angles are ``None`` if there is none.

        Raises
        ------
        InvalidInputError
            For an invalid number; names the number and the rule.
        """
    def to_toml(self, /) -> str:
        """
        The drive as a case file in SI units; ``from_toml`` of it gives the same drive to the last bit.
        """
    @property
    def transmission_ratio(self, /) -> float:
        """
        Input turns for one turn of the output; negative if they turn in opposite directions.
        """
    @property
    def turns_of_parts(self, /) -> list[tuple[int, int]]:
        """
        Turns of the planet, then of the deceleration balls, against the line of centres, each as (turns, turns of the
        input).
        """

@final
class Effect:
    """
    One entry of ``[[effect]]``: its id, port and expression (of an own effect only), and its numbers.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, id: str, port: str | None, expression: str | None, values: SupportsGetItem[int, tuple[str, SupportsFloat | SupportsIndex]]) -> Effect: ...
    def __reduce__(self, /) -> tuple[Any, tuple[str, str | None, str | None, list[tuple[str, float]]]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def expression(self, /) -> str | None:
        """
        Its expression, for an effect of the user's own.
        """
    @property
    def id(self, /) -> str:
        """
        Name of the effect.
        """
    @property
    def port(self, /) -> str | None:
        """
        Where it acts, for an effect of the user's own.
        """
    @property
    def values(self, /) -> list[tuple[str, float]]:
        """
        All numbers in SI: name (of an effect of the library with its unit), and value.
        """

@final
class EffectParameter:
    """
    A number of an effect. Values are SI; ``display_name`` and ``display_size`` give the unit that people read.
    """
    def __repr__(self, /) -> str: ...
    @property
    def display_name(self, /) -> str:
        """
        Name with the unit that people read, for example ``reference_deflection_um``.
        """
    @property
    def display_size(self, /) -> float:
        """
        SI value of one unit of ``display_name``.
        """
    @property
    def is_size(self, /) -> bool:
        """
        Whether it is a size: an effect vanishes if all its sizes are neutral.
        """
    @property
    def lower(self, /) -> float:
        """
        Least value that has a meaning.
        """
    @property
    def meaning(self, /) -> str:
        """
        What it is.
        """
    @property
    def name(self, /) -> str:
        """
        Name with its SI unit, for example ``reference_deflection_m``.
        """
    @property
    def neutral(self, /) -> float:
        """
        Value at which a size has no effect; for any other parameter its default.
        """
    @property
    def range(self, /) -> tuple[float, float]:
        """
        Plausible values, as a prior: lowest and highest.
        """
    @property
    def scale(self, /) -> str:
        """
        ``linear``, ``log``, or ``fixed`` for a whole number that is chosen, not fitted.
        """
    @property
    def upper(self, /) -> float:
        """
        Greatest value that has a meaning.
        """

@final
class EffectSpec:
    """
    An effect of the library.
    """
    def __repr__(self, /) -> str: ...
    @property
    def equation(self, /) -> str:
        """
        Its equation.
        """
    @property
    def id(self, /) -> str:
        """
        Its fixed id.
        """
    @property
    def kind(self, /) -> str:
        """
        ``parameter``, ``rig`` or ``effect``.
        """
    @property
    def parameters(self, /) -> list[EffectParameter]:
        """
        Its parameters.
        """
    @property
    def port(self, /) -> str:
        """
        Where it acts: ``load``, ``gap``, ``contact``, ``series`` or ``reading``.
        """
    @property
    def reducers(self, /) -> list[str]:
        """
        Kinds of reducer that can have it: ``ball_drive``, ``torsion_spring``.
        """
    @property
    def source(self, /) -> str:
        """
        Where the equation comes from.
        """
    @property
    def tell_tale(self, /) -> str:
        """
        How it shows in readings.
        """
    @property
    def twins(self, /) -> list[str]:
        """
        Ids of effects that no torque-angle data can tell from this one when the contact stiffness is fitted as well.
        """

@final
class Enclosure:
    """
    Intervals, lower and upper bound, in which the only solution of a drive's equations was proved to lie.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, elastic_angle_rad: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], elastic_angle_arcsec: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], alpha_deceleration_arcsec: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], alpha_equal_speed_arcsec: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex]) -> Enclosure: ...
    def __reduce__(self, /) -> tuple[Any, tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def alpha_deceleration_arcsec(self, /) -> tuple[float, float]:
        """
        Part of the deceleration pair, seconds of arc.
        """
    @property
    def alpha_equal_speed_arcsec(self, /) -> tuple[float, float]:
        """
        Part of the equal-speed pair that reaches the output, seconds of arc.
        """
    @property
    def elastic_angle_arcsec(self, /) -> tuple[float, float]:
        """
        Elastic angle of the drive at its output, seconds of arc.
        """
    @property
    def elastic_angle_rad(self, /) -> tuple[float, float]:
        """
        Elastic angle of the drive at its output, rad.
        """

@final
class Finding:
    """
    One finding about a design: its code, severity (note, warning, error), the pair, a message and the remedy.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, code: str, severity: str, pair: str, message: str, remedy: str) -> Finding: ...
    def __reduce__(self, /) -> tuple[Any, tuple[str, str, str, str, str]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def code(self, /) -> str:
        """
        Stable name, for example ``undercut``.
        """
    @property
    def message(self, /) -> str:
        """
        What was found, with the numbers.
        """
    @property
    def pair(self, /) -> str:
        """
        ``deceleration`` or ``equal_speed``.
        """
    @property
    def remedy(self, /) -> str:
        """
        What to change.
        """
    @property
    def severity(self, /) -> str:
        """
        ``note``, ``warning`` or ``error``.
        """

@final
class Friction:
    """
    Friction of a drive under a load: over a period, or at one angle of the crank.
    """
    def __repr__(self, /) -> str: ...
    @property
    def coefficient(self, /) -> float:
        """
        Friction coefficient.
        """
    @property
    def contacts(self, /) -> list[FrictionContact]:
        """
        Every loaded contact; empty for a period.
        """
    @property
    def deceleration(self, /) -> PairFriction | None:
        """
        The deceleration pair.
        """
    @property
    def efficiency(self, /) -> float | None:
        """
        Work at the output over work at the input; 0 without torque.
        """
    @property
    def equal_speed(self, /) -> PairFriction | None:
        """
        The equal-speed pair.
        """
    @property
    def friction_torque_Nm(self, /) -> float | None:
        """
        Friction torque of the drive at the input, N m: the mean over a period, or the value at the angle. ``None`` without
        solution, as all below.
        """
    @property
    def gap(self, /) -> float | None:
        """
        Largest relative distance of a ball's loss from its proved lower bound; ``None`` for a period.
        """
    @property
    def has_solution(self, /) -> bool:
        """
        Whether the load has a solution, so that the friction is a number.
        """
    def heat_W(self, /, input_speed_rpm: SupportsFloat | SupportsIndex) -> float | None:
        """
        Heat of the contacts, W, at a speed of the input (turns for each minute).
        """
    @property
    def input_angle_deg(self, /) -> float | None:
        """
        Angle of the input crank, degrees; ``None`` for a period.
        """
    @property
    def input_torque_Nm(self, /) -> float | None:
        """
        Torque at the input that drives the load, N m.
        """
    @property
    def preload_N(self, /) -> float:
        """
        Axial preload, N.
        """
    @property
    def ripple_Nm(self, /) -> float | None:
        """
        Largest minus smallest friction torque over a period, N m; 0 at one angle.
        """
    @property
    def status(self, /) -> str:
        """
        ``ok``, or why there is no solution.
        """
    @property
    def torque_Nm(self, /) -> float:
        """
        Torque on the output, N m.
        """
    @property
    def transmission_ratio(self, /) -> float:
        """
        Transmission ratio.
        """
    @property
    def wear_Nm_per_turn(self, /) -> float | None:
        """
        Archard's index of both pairs for a turn of the input: friction work over the coefficient, N m.
        """
    def with_coefficient(self, /, coefficient: SupportsFloat | SupportsIndex) -> float | None:
        """
        Friction torque at the input, N m, with another coefficient: it is proportional to the coefficient.
        """

@final
class FrictionContact:
    """
    One loaded contact of a ball with a groove, for each radian of the input.
    """
    @property
    def ball(self, /) -> int:
        """
        Number of the ball in its row, from 0.
        """
    @property
    def diagonal(self, /) -> str:
        """
        ``plus`` or ``minus``: the diagonal of the ball.
        """
    @property
    def force_N(self, /) -> float:
        """
        Normal force, N.
        """
    @property
    def pair(self, /) -> str:
        """
        ``deceleration`` or ``equal_speed``.
        """
    @property
    def pivoting(self, /) -> float:
        """
        Turn of the ball about the contact normal against the plate, for each radian of the input.
        """
    @property
    def row(self, /) -> int:
        """
        Row of the pair, from 0; only a cross-slide has two.
        """
    @property
    def side(self, /) -> int:
        """
        0 for the driving (epicycloid, planet) plate, 1 for the plate opposite.
        """
    @property
    def slip_m_per_rad(self, /) -> float:
        """
        Slip along the track, m for each radian of the input.
        """
    @property
    def torque_Nm(self, /) -> float:
        """
        Part of the friction torque at the input, N m.
        """

@final
class LargestAngle:
    """
    Largest elastic angle over a period of the drive.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, elastic_angle_arcsec: SupportsFloat | SupportsIndex, input_angle_deg: SupportsFloat | SupportsIndex, amplitude_arcsec: SupportsFloat | SupportsIndex, period_deg: SupportsFloat | SupportsIndex) -> LargestAngle: ...
    def __reduce__(self, /) -> tuple[Any, tuple[float, float, float, float]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def amplitude_arcsec(self, /) -> float:
        """
        Largest minus smallest size of the elastic angle, seconds of arc.
        """
    @property
    def elastic_angle_arcsec(self, /) -> float:
        """
        Largest elastic angle, with the sign of the torque, seconds of arc.
        """
    @property
    def input_angle_deg(self, /) -> float:
        """
        Crank angle where it occurs, degrees.
        """
    @property
    def period_deg(self, /) -> float:
        """
        Crank angle after which the drive repeats, degrees.
        """

@final
class Misfit:
    """
    Misfit of n readings with the priors of p unknowns.

    Parameters
    ----------
    readings : array, shape (n,)
        In arcsec.
    offsets : array, shape (n, k)
        Columns of what is always free, whitened.
    whitener : Whitener
        Of the noise.
    unknowns : tuple of array, shape (p,)
        Place among the values of the model, mean of the prior, one step, precision of the prior by steps (0: none), whether it is
        searched in logarithms, and the least and the most that it can be.
    """
    def __new__(cls, /, readings: NDArray[float64], offsets: NDArray[float64], whitener: Whitener, unknowns: tuple[NDArray[int64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[bool_], NDArray[float64], NDArray[float64]]) -> Misfit: ...
    def at(self, /, point: tuple[NDArray[float64], NDArray[float64], NDArray[float64]]) -> Seen:
        """
        What is seen at a point: values, angles in arcsec, slopes by the unknowns. Without slopes only the misfit and the
        readings less model.
        """
    def columns(self, /, point: tuple[NDArray[float64], NDArray[float64], NDArray[float64]]) -> NDArray[float64]:
        """
        Slopes by one step of each unknown, arcsec, shape (n, p).
        """
    def coordinates(self, /, values: NDArray[float64]) -> NDArray[float64]:
        """
        Of the unknowns at some values, logarithms where they are searched in these, shape (p,).
        """
    def search(self, /, predictor: Predictor, start: tuple[NDArray[float64], NDArray[float64], NDArray[float64]], limits: tuple[SupportsIndex, SupportsFloat | SupportsIndex, bool]) -> tuple[tuple[NDArray[float64], NDArray[float64], NDArray[float64]] | None, bool]:
        """
        The most probable point, ``None`` where that is the start, and whether the search came to its end.

        Parameters
        ----------
        predictor : Predictor
            Of the readings; goes on from the solutions that it has.
        start : tuple of array
            Values, angles in arcsec, and slopes by the unknowns, as those of the point returned.
        limits : tuple of int, float and bool
            Predictions after which it ends; the misfit above which it ends where what the last step promises stays there;
            whether the end is only ranked among others, and comes sooner.

        Raises
        ------
        numpy.linalg.LinAlgError
            Where slopes are not finite.
        InvalidInputError
            For a value out of its bounds.
        """
    def step(self, /, seen: Seen, radius: SupportsFloat | SupportsIndex, scale: NDArray[float64]) -> tuple[NDArray[float64], float]:
        """
        The step, shape (p,), that the linear problem asks for within the bounds, and what it promises.

        Parameters
        ----------
        seen : Seen
            With slopes.
        radius : float
            The longest step.
        scale : array, shape (p,)
            By which each unknown is measured, above 0.

        Raises
        ------
        numpy.linalg.LinAlgError
            Where the slopes are not finite.
        """
    def values_at(self, /, values: NDArray[float64], coordinates: NDArray[float64]) -> NDArray[float64]:
        """
        Some values with the unknowns at these coordinates.
        """

@final
class NoiseFilter:
    """
    Whitens n readings that scatter beside an autoregression along their runs.

    Parameters
    ----------
    sd : array, shape (n,)
        Standard deviation of each reading by the autoregression.
    correlation : float
        From a reading to the next of its run.
    order : array of int, shape (n,)
        The readings run by run.
    before : array of int, shape (n,)
        The reading before each one in its run, or -1.
    own : array, shape (n,), optional
        Standard deviation by which each reading scatters by itself.
    held : tuple of array, optional
        Of what readings share while a torque was held: the standard deviation of each reading, shape (n,), and its hold, int,
        shape (n,).
    """
    def __new__(cls, /, sd: NDArray[float64], correlation: SupportsFloat | SupportsIndex, order: NDArray[int64], before: NDArray[int64], own: NDArray[float64] | None, held: tuple[NDArray[float64], NDArray[int64]] | None) -> NoiseFilter: ...
    @property
    def log_det(self, /) -> float:
        """
        Logarithm of the determinant of the covariance.
        """

@final
class NoisePolynomials:
    """
    Products of columns through a noise of any scale and correlation, of readings that differences whiten.

    Parameters
    ----------
    grams : list of array, shape (m, m)
        Products of the columns over the standard deviations: of first readings of runs, of followers, of followers with those
        before them (twice, negative), of those before.
    by_run : list of array, shape (runs, m + 1)
        The same run by run, of the columns with a column of ones, and of that with itself.
    log_det : float
        Log determinant of the covariance at a scale of 1 without correlation.
    readings : tuple of int
        How many there are, and how many of them follow another one in their run.
    """
    def __new__(cls, /, grams: SupportsLenAndGetItem[NDArray[float64]], by_run: SupportsLenAndGetItem[NDArray[float64]], log_det: SupportsFloat | SupportsIndex, readings: SupportsLenAndGetItem[SupportsIndex]) -> NoisePolynomials: ...

@final
class OwnEffect:
    """
    An effect that the user defines. Make one with :func:`cbpt.effects.expression` or :func:`cbpt.effects.own_effect`.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[Any]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def adds_to(self, /) -> str:
        """
        ``torque_Nm``, ``preload_N`` or ``angle_rad``.
        """
    @property
    def expression(self, /) -> str | None:
        """
        Its formula, or ``None`` for a function.
        """
    @staticmethod
    def from_entry(entry: "dict[str, Any]") -> OwnEffect:
        """
        Makes an effect from the keys of an ``[[effect]]`` with an expression. Raises ``CaseError`` with key and place.
        """
    @staticmethod
    def from_function(id: str, port: str, adds_to: str | None, function: Any, parameters: SupportsGetItem[int, tuple[str, str, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex | None, SupportsFloat | SupportsIndex | None]]) -> OwnEffect:
        """
        Makes an effect from a function of Python.

        Parameters
        ----------
        id : str
            Name of the effect.
        port : str
            ``load``, ``series`` or ``reading``.
        adds_to : str or None
            At the port ``load``: ``torque_Nm`` or ``preload_N``.
        function : callable
            Takes all columns (a dict of arrays) and the values of the parameters (a list), and returns an array with one number
            for each row. Its attribute ``used`` is the set of columns that it reads.
        parameters : list of tuple
            Name, unit, start, least and greatest value of each parameter, in that unit.

        Returns
        -------
        OwnEffect
            The effect.

        Raises
        ------
        InvalidInputError, CaseError
            For a name, a port or a parameter that is not allowed.
        """
    @property
    def id(self, /) -> str:
        """
        Its name.
        """
    @property
    def parameters(self, /) -> list[tuple[str, str, float, float | None, float | None]]:
        """
        Name, SI unit, start, least and greatest value of each parameter, in SI.
        """
    @property
    def port(self, /) -> str:
        """
        ``load``, ``series`` or ``reading``.
        """
    @property
    def stated_units(self, /) -> dict[str, str]:
        """
        The unit in which each parameter was stated.
        """
    def to_toml(self, /) -> str:
        """
        The ``[[effect]]`` of a case file as TOML text. Raises ``InvalidInputError`` for a function.
        """
    def uses(self, /, variable: str) -> bool:
        """
        Whether it depends on a variable, for example ``time_s``; for a function, whether it has read that column.
        """

@final
class PairFriction:
    """
    Friction torque of a pair at the input, N m.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    @property
    def ripple_Nm(self, /) -> float:
        """
        Largest minus smallest value over a period, N m; 0 at one angle.
        """
    @property
    def torque_Nm(self, /) -> float:
        """
        Friction torque at the input, N m: the mean over a period, or the value at the angle.
        """
    @property
    def track_wear_Nm_per_mm(self, /) -> tuple[float, float]:
        """
        Largest index for a turn of the input and a length of track, of the grooves of the driving plate and of the plate
        opposite, N m/mm.
        """
    @property
    def wear_Nm_per_turn(self, /) -> float:
        """
        Archard's index for a turn of the input: friction work over the coefficient, N m.
        """

@final
class PairSolution:
    """
    A solved pair. Arrays have one element for each diagonal of a ball (two meshing points that carry the same force), ball by
    ball, plus before minus; arrays of the walls have two columns, first the wall of the driving plate.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[Solution]]:
        """
        Pickled as part of its solution.
        """
    def __repr__(self, /) -> str: ...
    @property
    def angle_arcsec(self, /) -> float:
        """
        Elastic angle of the pair, seconds of arc.
        """
    @property
    def angle_rad(self, /) -> float:
        """
        Elastic angle of the pair, rad.
        """
    @property
    def approach_m(self, /) -> float:
        """
        Axial approach of the plates (of one row), m.
        """
    @property
    def ball(self, /) -> NDArray[uint32]:
        """
        Number of the ball, shape (n,).
        """
    @property
    def carrying(self, /) -> int:
        """
        How many diagonals carry force.
        """
    @property
    def contact(self, /) -> list[str]:
        """
        ``loaded``, ``parted`` or ``wall_missing`` for each diagonal.
        """
    @property
    def deformation_m(self, /) -> NDArray[float64]:
        """
        Deformation of each diagonal, m, never below 0, shape (n,).
        """
    @property
    def diagonal(self, /) -> NDArray[float64]:
        """
        +1 for the plus diagonal, -1 for the minus diagonal, shape (n,).
        """
    @property
    def force_N(self, /) -> NDArray[float64]:
        """
        Normal force of each diagonal, N, shape (n,).
        """
    @property
    def gap_m(self, /) -> NDArray[float64]:
        """
        Gap of each diagonal, m, never below 0, shape (n,).
        """
    @property
    def in_plane_force_across_N(self, /) -> float:
        """
        Force of the balls on the output plate across the line of centres, N: for the deceleration pair M0/(Zo e), what
        the eccentric bearing carries.
        """
    @property
    def in_plane_force_along_N(self, /) -> float:
        """
        Force of the balls on the output plate along the line of centres, N.
        """
    @property
    def largest_peak_pressure_Pa(self, /) -> float:
        """
        Highest peak pressure of any meshing point, Pa.
        """
    @property
    def major_semi_axis_m(self, /) -> NDArray[float64]:
        """
        Major semi-axis of each contact ellipse, m, shape (n, 2); NaN where the wall is missing.
        """
    @property
    def minor_semi_axis_m(self, /) -> NDArray[float64]:
        """
        Minor semi-axis of each contact ellipse, m, shape (n, 2); NaN where the wall is missing.
        """
    @property
    def peak_pressure_Pa(self, /) -> NDArray[float64]:
        """
        Peak pressure at each meshing point, Pa, shape (n, 2); NaN where the wall is missing.
        """
    @property
    def residual(self, /) -> float:
        """
        Scaled residual.
        """
    @property
    def role(self, /) -> list[str]:
        """
        ``FTMP``, ``NFTMP`` or ``neutral`` for each diagonal.
        """
    @property
    def sideways_m(self, /) -> float:
        """
        Sideways shift of a floating plate, m.
        """
    @property
    def steps(self, /) -> int:
        """
        Solver steps.
        """
    @property
    def tilt_couple_Nm(self, /) -> float:
        """
        Couple that tilts the plates, N m.
        """
    @property
    def torque_Nm(self, /) -> float:
        """
        Torque that the pair carries, N m.
        """
    @property
    def torsional_stiffness_Nm_per_rad(self, /) -> float:
        """
        Torsional stiffness dM0/dalpha at constant preload, N m/rad.
        """
    @property
    def wall_approach_m(self, /) -> NDArray[float64]:
        """
        Approach at each meshing point, m, shape (n, 2); NaN where the wall is missing.
        """

@final
class Prediction:
    """
    What an ideal instrument would show, row by row.
    """
    def __repr__(self, /) -> str: ...
    @property
    def angle_rad(self, /) -> NDArray[float64]:
        """
        Elastic angle as the instrument shows it, rad, shape (n,); NaN where there is no solution.
        """
    @property
    def carrying(self, /) -> NDArray[uint32]:
        """
        Diagonals that carry in one row of the deceleration and of the equal-speed pair, shape (n, 2).
        """
    @property
    def hold_preload_N(self, /) -> NDArray[float64]:
        """
        Preload at which each torque would just slip, N, shape (n,), where the status is ``beyond_hold``; else NaN.
        """
    @property
    def parts_rad(self, /) -> NDArray[float64]:
        """
        Parts of the meshing points, rad, shape (n, 2): of the deceleration pair, and what of the equal-speed pair reaches the
        output; NaN where there is no solution.
        """
    @property
    def regime(self, /) -> NDArray[uint8]:
        """
        Which contacts carry, shape (n,): 0 all that exist, 1 some have parted, 2 below continuous transmission (d <= 0 in
        a pair), 255 no solution or a torsion spring.
        """
    @property
    def residual(self, /) -> NDArray[float64]:
        """
        Largest scaled residual of each row, shape (n,); NaN where there is no solution.
        """
    @property
    def sensitivities(self, /) -> NDArray[float64]:
        """
        Derivative of the angle by each of the wanted parameters, rad per SI unit, shape (n, len(wanted)); NaN where there
        is no solution.
        """
    @property
    def solved(self, /) -> NDArray[uint8]:
        """
        Whether each row has a solution, 1 or 0, shape (n,).
        """
    @property
    def status(self, /) -> list[str]:
        """
        Status of each row: ``ok``, ``outside_small_displacements``, ``outside_table``, ``beyond_hold``, ``undercut``,
        ``indeterminate`` or ``not_converged``.
        """

@final
class Predictor:
    """
    A drive with effects on a table of readings.

    Meshing points and solutions are kept from call to call, so a fit pays for changes only; an answer does not depend on earlier
    calls beyond the tolerance of the equations, and not at all after ``cold``. Calls from several threads wait for each other.

    Parameters
    ----------
    drive : Drive
        A ball drive or a torsion spring.
    effects : list of str or OwnEffect
        Ids of the library, one as often as wanted, and own effects.
    run : array of int, shape (n,)
        The run of each reading.
    time_s : array, shape (n,)
        In order within a run.
    torque_Nm : array, shape (n,)
        Of either sign.
    preload_N : array, shape (n,), or None
        Above 0; ``None`` for a torsion spring without a preload.
    input_angle_rad : array, shape (n,)
        Angle of the input crank.
    temperature_K : array, shape (n,), optional
        Where it was read; degrees Celsius will do, as only differences count.
    cycle : array, shape (n,), optional
        Load cycle of each reading, where it was counted.

    Raises
    ------
    InvalidInputError
        Names column, row and rule.
    """
    def __copy__(self, /) -> Predictor:
        """
        Another one like it, for a thread of its own.
        """
    def __new__(cls, /, drive: Drive, effects: SupportsGetItem[int, str | OwnEffect], run: NDArray[int64], time_s: NDArray[float64], torque_Nm: NDArray[float64], preload_N: NDArray[float64] | None, input_angle_rad: NDArray[float64], temperature_K: NDArray[float64] | None = None, cycle: NDArray[float64] | None = None, torque_turns: str = "where_ramps_meet") -> Predictor: ...
    def __repr__(self, /) -> str: ...
    def cold(self, /) -> None:
        """
        Forgets the solutions of earlier calls, from which the next one would start: what follows is to the last bit what a
        new predictor would say. Meshing points are kept.
        """
    def contributions(self, /, values: NDArray[float64]) -> list[tuple[str, NDArray[float64]]]:
        """
        Named parts of the angle at ``values`` (p,): ``model`` without effects, then what each effect adds as they are
        switched on in the order of the ports; each rad, shape (n,). They add up to the angle.
        """
    @property
    def drive(self, /) -> Drive:
        """
        The drive without effects.
        """
    @property
    def effects(self, /) -> list[str]:
        """
        Ids of the effects, in the order given.
        """
    def neutral(self, /) -> NDArray[float64]:
        """
        Values at which every effect of the library vanishes, shape (p,); what is no size has its default, and own effects
        have their starts.
        """
    @property
    def parameters(self, /) -> list[tuple[int, str, EffectParameter]]:
        """
        The numbers of all effects, in the order of ``values``: index of the effect, its id, the number.
        """
    def predict(self, /, values: NDArray[float64], wanted: SupportsGetItem[int, SupportsIndex] | None = None) -> Prediction:
        """
        Predicts all rows at ``values`` (p,), and the exact derivatives by the parameters whose indices are ``wanted``.

        Raises ``InvalidInputError`` for a value out of its bounds and for a wanted parameter that is chosen, not fitted. A
        row without solution has its status, NaN angle and NaN derivatives.
        """
    @property
    def readings_are_means(self, /) -> bool:
        """
        Whether the readings are means over time, from halfway to the one before to halfway to the next, as those over turns say.
        """
    @property
    def runs_that_go_on(self, /) -> int:
        """
        How many runs go on from where the one before them ended, with the friction that it has left.
        """
    @property
    def runs_with_unmeasured_past(self, /) -> int:
        """
        How many runs go on from a repetition of themselves, or a loop, that nobody measured.
        """
    def take_history(self, /, word: str) -> None:
        """
        From now on the friction of runs goes on, or not, as a case says by its word for `friction_between_runs`. Raises
        ``InvalidInputError`` for any other word.
        """
    @property
    def turns_between_readings(self, /) -> list[int]:
        """
        Rows of the readings before each turn of the torque between readings, or over it, as both ramps beside it say.
        """

@final
class PreloadThresholds:
    """
    Thresholds of both pairs and of the drive, in terms of the torque on the drive's output.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, torque_Nm: SupportsFloat | SupportsIndex, input_angle_deg: SupportsFloat | SupportsIndex | None, deceleration: Thresholds, equal_speed: Thresholds) -> PreloadThresholds: ...
    def __reduce__(self, /) -> tuple[Any, tuple[float, float | None, Thresholds, Thresholds]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def deceleration(self, /) -> Thresholds:
        """
        Of the deceleration pair.
        """
    @property
    def drive(self, /) -> Thresholds:
        """
        Of the drive: the larger of each.
        """
    @property
    def equal_speed(self, /) -> Thresholds:
        """
        Of the equal-speed pair.
        """
    @property
    def input_angle_deg(self, /) -> float | None:
        """
        Angle of the input crank, degrees; ``None`` for maxima over a period.
        """
    @property
    def torque_Nm(self, /) -> float:
        """
        Torque on the output, N m.
        """

@final
class Seen:
    """
    What a misfit sees of a point: n readings less model, and p columns.
    """
    @property
    def coordinates(self, /) -> NDArray[float64]:
        """
        Of the unknowns, logarithms where they are searched in these, shape (p,).
        """
    @property
    def misfit(self, /) -> float:
        """
        Whitened misfit after the best offsets, and priors.
        """
    @property
    def off(self, /) -> NDArray[float64]:
        """
        Unknowns off the mean of their priors, in steps, shape (p,); 0 where there is no prior.
        """
    @property
    def reach(self, /) -> NDArray[float64]:
        """
        How far readings and priors see one step of each unknown, in standard deviations, shape (p,).
        """
    @property
    def x(self, /) -> NDArray[float64]:
        """
        Slopes by one step of each unknown, whitened, shape (n, p).
        """
    @property
    def x_left(self, /) -> NDArray[float64]:
        """
        As ``x``, less what the offsets take.
        """
    @property
    def y(self, /) -> NDArray[float64]:
        """
        Readings less model, whitened, shape (n,).
        """
    @property
    def y_left(self, /) -> NDArray[float64]:
        """
        As ``y``, less what the offsets take.
        """

@final
class Sensitivities:
    """
    How the results of a drive under a load answer to its design numbers.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, status: str, numbers: dict[str, SupportsFloat | SupportsIndex], results: dict[str, Sensitivity | None], report: str) -> Sensitivities: ...
    def __reduce__(self, /) -> tuple[Any, tuple[str, dict[str, float], dict[str, Sensitivity | None], str]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def elastic_angle(self, /) -> Sensitivity | None:
        """
        The elastic angle at the output; ``None`` where there is no solution.
        """
    @property
    def numbers(self, /) -> dict[str, float]:
        """
        The numbers and their values, SI.
        """
    @property
    def report(self, /) -> str: ...
    @property
    def results(self, /) -> dict[str, Sensitivity | None]:
        """
        Results by name: ``elastic_angle_rad`` and its parts ``deceleration_angle_rad`` and ``equal_speed_angle_rad``, ``None``
        without a solution; ``hold_N``, ``continuous_N`` and ``zero_backlash_N`` of the drive, and of each pair with
        ``deceleration_`` or ``equal_speed_`` before the name, over a period, ``None`` where no preload does it. With a friction
        coefficient also ``friction_torque_Nm``, ``efficiency``, ``wear_Nm_per_turn`` and ``static_safety``, and with an inertia
        ``natural_frequency_Hz``, all at the input angle and by central differences.
        """
    @property
    def status(self, /) -> str:
        """
        How the load ended.
        """

@final
class Sensitivity:
    """
    A result, and how it answers to each number; numbers by their names in SI (``deceleration.ball_radius_m``).
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, value: SupportsFloat | SupportsIndex, slopes: dict[str, SupportsFloat | SupportsIndex], relative: dict[str, SupportsFloat | SupportsIndex], one_sided: SupportsGetItem[int, str]) -> Sensitivity: ...
    def __reduce__(self, /) -> tuple[Any, tuple[float, dict[str, float], dict[str, float], list[str]]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def one_sided(self, /) -> list[str]:
        """
        Numbers to which contacts that decide alike answer differently: the derivative is to one side.
        """
    @property
    def relative(self, /) -> dict[str, float]:
        """
        Percent of the result for a percent of each number; without those of a result of 0.
        """
    @property
    def slopes(self, /) -> dict[str, float]:
        """
        Its derivative by each number, SI.
        """
    @property
    def value(self, /) -> float:
        """
        The result, SI.
        """

@final
class Solution:
    """
    A drive under one load. Print it for a summary; its angles are ``None`` where there is no solution.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[float, float | None, float]]:
        """
        Pickled as drive and load; solving again gives the same numbers.
        """
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str:
        """
        What a notebook shows.
        """
    @property
    def alpha_deceleration_arcsec(self, /) -> float | None:
        """
        Part of the deceleration pair, seconds of arc.
        """
    @property
    def alpha_equal_speed_arcsec(self, /) -> float | None:
        """
        Part of the equal-speed pair that reaches the output, seconds of arc.
        """
    @property
    def deceleration(self, /) -> PairSolution | None:
        """
        The deceleration pair with its meshing points.
        """
    @property
    def elastic_angle_arcsec(self, /) -> float | None:
        """
        Elastic angle of the drive at its output, seconds of arc.
        """
    @property
    def elastic_angle_rad(self, /) -> float | None:
        """
        Elastic angle of the drive at its output, rad.
        """
    @property
    def enclosure(self, /) -> Enclosure | None:
        """
        Where the elastic angle lies for certain, rounding included, with the proof that there is no other solution; ``None``
        without a solution, where no proof was found, and for a torsion spring. It is worked out each time it is asked for.
        """
    @property
    def equal_speed(self, /) -> PairSolution | None:
        """
        The equal-speed pair with its meshing points, at the torque that it carries.
        """
    @property
    def findings(self, /) -> list[Finding]:
        """
        Findings of the design under this load, the worst first.
        """
    @property
    def has_solution(self, /) -> bool:
        """
        Whether the load has a solution, so that the angles are numbers.
        """
    @property
    def hold_preload_N(self, /) -> float | None:
        """
        Preload at which the torque would just slip, N, if the status is ``beyond_hold``; ``None`` otherwise.
        """
    @property
    def input_angle_deg(self, /) -> float:
        """
        Angle of the input crank, degrees.
        """
    @property
    def message(self, /) -> str:
        """
        The status in words; for ``beyond_hold`` with the preload that would hold.
        """
    @property
    def preload_N(self, /) -> float | None:
        """
        Axial preload, N; ``None`` for a torsion spring without one.
        """
    @property
    def residual(self, /) -> float | None:
        """
        Largest residual of the equations, scaled by the preload and by the torque that it can hold.
        """
    @property
    def status(self, /) -> str:
        """
        ``ok``, ``outside_small_displacements`` (the linear geometry no longer holds), ``beyond_hold``,
        ``undercut``, ``indeterminate`` (too few points touch) or ``not_converged``.
        """
    def to_json(self, /) -> str:
        """
        The whole solution as the JSON object that ``cbpt solve --json`` prints.
        """
    @property
    def torque_Nm(self, /) -> float:
        """
        Torque on the output, N m.
        """
    @property
    def torsional_stiffness_Nm_per_rad(self, /) -> float | None:
        """
        Torsional stiffness dM0/dalpha of the drive at this load and constant preload, N m/rad.
        """

@final
class SweepCsv:
    """
    A CSV file that grows chunk by chunk. A sweep that was interrupted continues where it stopped.

    Raises ``PlanError`` if the file belongs to another plan, if another process writes it or if it was changed since, and
    ``OSError`` if it cannot be written.
    """
    def __new__(cls, /, plan: SweepPlan, path: str | PathLike[str], fresh: bool = False) -> SweepCsv: ...
    def append(self, /, lines: bytes, rows: SupportsIndex) -> None:
        """
        Adds the lines of the next rows, and returns when they are on disk.
        """
    @property
    def done(self, /) -> int:
        """
        Rows that are on disk.
        """

@final
class SweepPlan:
    """
    A sweep as data: a case, its axes, and the design of its rows. Each row depends only on the plan and on its number, so
    any process can solve any part.

    Axes are pairs of a name, which is a key of the case with its section, and values in the unit of that key. ``cbpt.sweep``
    takes simpler forms of them.
    """
    def __new__(cls, /, case: Case, axes: "list[tuple[str, tuple[float, float, bool] | NDArray[float64] | list[str]]]", design: str = "grid", rows: SupportsIndex | None = None, seed: SupportsIndex = 0, columns: SupportsGetItem[int, str] = ...) -> SweepPlan:
        """
        Makes a plan.

        Parameters
        ----------
        case : Case
            What stays the same.
        axes : list of tuple
            Key and values of each axis: a range (start, stop, whether in logarithms), an array or words.
        design : str, optional
            ``grid``, ``random``, ``latin_hypercube`` or ``table``.
        rows : int, optional
            Number of rows of ``random`` and ``latin_hypercube``.
        seed : int, optional
            Seed of their random numbers.

        columns : list of str, optional
            Further columns, of the drive alone: ``friction_torque_Nm``, ``efficiency``, ``wear_Nm_per_turn``, ``static_safety``,
            ``natural_frequency_Hz``.

        Raises
        ------
        PlanError
            Names the axis, what was found and what is allowed.
        """
    def __reduce__(self, /) -> tuple[Any, tuple[str, list[tuple[str, tuple[float, float, bool] | NDArray[float64] | list[str]]], str, int, int, int, list[str]]]: ...
    def __repr__(self, /) -> str: ...
    @staticmethod
    def _of(case: str, axes: "list[tuple[str, tuple[float, float, bool] | NDArray[float64] | list[str]]]", design: str, rows: SupportsIndex, seed: SupportsIndex, first: SupportsIndex, columns: SupportsGetItem[int, str]) -> SweepPlan:
        """
        Makes a plan from the state of ``__reduce__``.
        """
    def check_output(self, /, path: str | PathLike[str]) -> None:
        """
        Raises ``PlanError`` if the plan was read from the file ``path``.
        """
    def check_record(self, /, path: str | PathLike[str], record: str) -> None:
        """
        Raises ``PlanError`` with the differences if ``record``, found at ``path``, is the record of another plan.
        """
    def chunks(self, /, done: SupportsIndex = 0, chunk_rows: SupportsIndex | None = None) -> list[tuple[int, int]]:
        """
        The parts (first row, row after the last) in which a sweep is solved after ``done`` rows: whole blocks of at least
        ``chunk_rows`` rows.
        """
    @property
    def columns(self, /) -> list[str]:
        """
        Names of the further columns, in their order.
        """
    def csv(self, /, start: SupportsIndex, stop: SupportsIndex, threads: SupportsIndex | None = None, progress: Any | None = None) -> bytes:
        """
        Solves rows of the plan as ``solve`` does, and writes them as lines of a CSV file. Ctrl-C stops it.

        Parameters
        ----------
        start, stop : int
            First row, and the row after the last.
        threads : int, optional
            Number of threads; all cores if not given.
        progress : callable, optional
            Called from time to time with the number of rows done.

        Returns
        -------
        bytes
            The lines, without the header.

        Raises
        ------
        PlanError
            For rows that the plan does not have.
        """
    @property
    def design(self, /) -> str:
        """
        ``grid``, ``random``, ``latin_hypercube`` or ``table``.
        """
    def finding(self, /, row: SupportsIndex) -> str | None:
        """
        Why the drive of a row, counted from 0, cannot be built; ``None`` if it can.
        """
    @staticmethod
    def from_file(path: str | PathLike[str]) -> SweepPlan:
        """
        Reads a plan in TOML, with the case and the table that it names. Raises ``PlanError`` with file, line and key.
        """
    @property
    def has_findings(self, /) -> bool:
        """
        Whether the drive varies; each row then says whether its drive can be built.
        """
    @property
    def has_pairs(self, /) -> bool:
        """
        Whether the rows are those of a ball drive, which has parts and a preload to hold.
        """
    @property
    def meanings(self, /) -> list[str]:
        """
        What each axis is, in words.
        """
    @property
    def names(self, /) -> list[str]:
        """
        Names of the axes, in their order.
        """
    def part(self, /, start: SupportsIndex, stop: SupportsIndex) -> SweepPlan:
        """
        The plan reduced to what these rows need; a table keeps only their part.
        """
    def reason(self, /, row: SupportsIndex) -> str | None:
        """
        Why a row, counted from 0, has the status ``invalid_input``: the number that breaks a rule, its value in SI and the
        rule; ``None`` if the row has another status.
        """
    @property
    def record(self, /) -> str:
        """
        The plan as JSON, for the record beside its rows.
        """
    @property
    def remarks(self, /) -> list[str]:
        """
        Remarks before the sweep: a range whose steps do not reach its end, or a drive of all rows that cannot be built.
        """
    @property
    def rows(self, /) -> int:
        """
        Number of rows.
        """
    @property
    def seed(self, /) -> int:
        """
        Seed of the random numbers of the designs ``random`` and ``latin_hypercube``.
        """
    def solve(self, /, start: SupportsIndex, stop: SupportsIndex, threads: SupportsIndex | None = None, progress: Any | None = None) -> tuple[list[NDArray[float64]], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[uint8], NDArray[uint8], list[NDArray[float64]]]:
        """
        Solves rows of the plan. Ctrl-C stops it.

        Parameters
        ----------
        start, stop : int
            First row, and the row after the last.
        threads : int, optional
            Number of threads; all cores if not given.
        progress : callable, optional
            Called from time to time with the number of rows done.

        Returns
        -------
        tuple
            The columns of the axes (a list), then elastic angle, part of the deceleration pair and part of the equal-speed
            pair (rad), scaled residual, preload to hold (N), index of the finding in ``sweep_findings()`` (empty unless
            ``has_findings``) and index of the status in ``sweep_statuses()``, each of shape (stop - start,); and a list of the
            further ``columns``.

        Raises
        ------
        PlanError
            For rows that the plan does not have.
        """
    @property
    def strides(self, /) -> list[int]:
        """
        Number of rows after which the value of each axis of a grid changes: the load changes fastest, the drive slowest.
        """
    @property
    def units(self, /) -> list[str]:
        """
        Unit of each axis as keys write it; empty for plain numbers and words.
        """
    def values(self, /) -> list[tuple[float, float, bool] | NDArray[float64] | list[str]]:
        """
        The values of each axis as they were given.
        """
    @property
    def words(self, /) -> list[list[str]]:
        """
        The words of each axis; empty for an axis of numbers.
        """

@final
class SweepTally:
    """
    Counts how the rows of a sweep ended, with the reasons of those that have the status ``invalid_input``.
    """
    def __new__(cls, /, plan: SweepPlan) -> SweepTally: ...
    def add(self, /, start: SupportsIndex, status: SupportsGetItem[int, SupportsIndex], finding: SupportsGetItem[int, SupportsIndex]) -> None:
        """
        Counts rows from row ``start`` on, by the indices of their statuses and findings.
        """
    def text(self, /) -> str | None:
        """
        The summary as text; ``None`` if every row has a solution and a drive that can be built.
        """

@final
class Thresholds:
    """
    The three preloads that a torque needs, N; infinite if no preload is enough.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, hold_N: SupportsFloat | SupportsIndex, continuous_N: SupportsFloat | SupportsIndex, zero_backlash_N: SupportsFloat | SupportsIndex) -> Thresholds: ...
    def __reduce__(self, /) -> tuple[Any, tuple[float, float, float]]: ...
    def __repr__(self, /) -> str: ...
    @property
    def continuous_N(self, /) -> float:
        """
        At this preload and above, no ball comes loose (the paper's minimum APF).
        """
    @property
    def hold_N(self, /) -> float:
        """
        The drive holds the torque at preloads above this one.
        """
    @property
    def zero_backlash_N(self, /) -> float:
        """
        At this preload and above, every meshing point stays in contact.
        """

@final
class Unit:
    """
    A unit: what it measures, how it is written and its exact conversion to SI.
    """
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self, /) -> int: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, /, symbol: str) -> Unit:
        """
        The unit with this symbol, as in ``units``; ``ValueError`` for an unknown symbol.
        """
    def __reduce__(self, /) -> tuple[Any, tuple[str]]: ...
    def __repr__(self, /) -> str: ...
    def conversion(self, /, to: Unit) -> tuple[float, float, float]:
        """
        Numbers ``(times, over, plus)``: a value in this unit is ``value * times / over + plus`` in ``to``.

        ``times`` and ``over`` are whole numbers if the conversion has no factor pi; it is then rounded once if one of them
        is 1. ``ValueError`` if ``to`` measures another quantity.
        """
    @property
    def offset(self, /) -> float:
        """
        SI value of 0 in this unit: 273.15 K for ``degC``, 0 for every other unit.
        """
    @property
    def quantity(self, /) -> str:
        """
        What it measures: ``angle``, ``torque per angle``.
        """
    @property
    def size(self, /) -> float:
        """
        SI value of one unit, without the offset.
        """
    @property
    def spellings(self, /) -> list[str]:
        """
        Other spellings that are accepted, written here without blanks, dots and hyphens between their parts.
        """
    @property
    def symbol(self, /) -> str:
        """
        Suffix of names, keys and columns, as in ``torque_Nm``; empty for plain numbers.
        """
    @property
    def written(self, /) -> str:
        """
        How it is written in a sentence, as in ``5 N m``.
        """

@final
class Whitener:
    """
    A root of the inverse of a covariance of n readings.

    Parameters
    ----------
    inverse : array, shape (n,)
        One over the standard deviation of each reading.
    correlation : float
        From a reading to the next of its run.
    before : array of int, shape (n,)
        The reading before each one in its run, or -1.
    offsets : tuple of array, optional
        Run of each reading, shape (n,); a column of ones, whitened, shape (n,); by how much each run's is shortened over its
        square, shape (runs,).
    shared : list of tuple of array
        Of what moves many readings at once: orthonormal axes, shape (n, k), and by how much each is shortened, shape (k,).
    filter : NoiseFilter, optional
        Of noise that no differences whiten.
    """
    def __new__(cls, /, inverse: NDArray[float64], correlation: SupportsFloat | SupportsIndex, before: NDArray[int64], offsets: tuple[NDArray[int64], NDArray[float64], NDArray[float64]] | None, shared: SupportsGetItem[int, tuple[NDArray[float64], NDArray[float64]]], filter: NoiseFilter | None) -> Whitener: ...
    def whitened(self, /, columns: NDArray[float64]) -> NDArray[float64]:
        """
        Columns of shape (n, m), whitened.
        """

def ball_loads(drive: Drive, torque_Nm: SupportsFloat | SupportsIndex, preload_N: SupportsFloat | SupportsIndex, input_angle_rad: NDArray[float64]) -> tuple[NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64]]:
    """
    What every ball of a drive carries at many angles of the crank. Ctrl-C stops it.

    Parameters
    ----------
    drive : Drive
        A ball drive.
    torque_Nm : float
        Torque on the output, N m.
    preload_N : float
        Axial preload, N.
    input_angle_rad : array, shape (n,)
        Angles of the input crank, rad.

    Returns
    -------
    tuple
        Axial force (N), share of the pair's torque (N m) and larger normal force (N) of each ball of the deceleration pair,
        then of the equal-speed pair (of a cross-slide its first row), each of shape (n, balls). NaN where there is no
        solution.

    Raises
    ------
    InvalidInputError
        For an invalid number, and for a torsion spring.
    """

def design_number(case: Case, key: str, values: SupportsGetItem[int, SupportsFloat | SupportsIndex]) -> tuple[str, list[float], bool]:
    """
    The design number with a key of case files (``deceleration.ball_radius_mm``): its name in SI, the values in SI,
    and whether it is a whole number.

    Raises ``InvalidInputError`` with the nearest key for an unknown one, or for an invalid value.
    """

def design_numbers() -> dict[str, tuple[str, float]]:
    """
    Design numbers by their names in SI: the key in the usual unit, and the number of usual units in one SI unit.
    """

def effect_specs() -> list[EffectSpec]:
    """
    Every effect of the library, in the order of all documents.
    """

def example_case() -> str:
    """
    The example case file: the base case of the 2017 paper, as TOML text.
    """

def friction_of_loads(drive: Drive, torque_Nm: NDArray[float64], preload_N: NDArray[float64], coefficient: SupportsFloat | SupportsIndex, progress: Any | None = None) -> tuple[NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], list[str]]:
    """
    Friction of a drive over a period for arrays of loads, on all cores. Ctrl-C stops it.

    Parameters
    ----------
    drive : Drive
        A ball drive.
    torque_Nm, preload_N : array, shape (n,)
        The loads: N m and N.
    coefficient : float
        Friction coefficient.
    progress : callable, optional
        Called from time to time with the number of loads computed.

    Returns
    -------
    tuple
        Mean, least and largest friction torque at the input (N m), efficiency and Archard's index for a turn of the input
        (N m), each of shape (n,), NaN where there is no solution, and the status of each load.

    Raises
    ------
    InvalidInputError
        For an invalid number, and for a torsion spring.
    """

def held_at_bounds(asked: Any, pull: Any, lower: NDArray[float64], upper: NDArray[float64]) -> NDArray[float64]:
    """
    The step within bounds of a linear problem that functions tell of, shape (p,).

    Parameters
    ----------
    asked : callable
        Given a step, shape (p,), and which unknowns are free, a mask of shape (p,): the step of those, shape (free,), where the
        others have made theirs.
    pull : callable
        Given a step, half the slope of the gain after it, shape (p,).
    lower, upper : array, shape (p,)
        Of the step; 0 is between them.
    """

def is_sweep_plan(path: str | PathLike[str]) -> bool:
    """
    Whether a file is a plan of a sweep and not a case; false for a file that cannot be read.
    """

def judge_designs(drive: Drive, torque_Nm: SupportsFloat | SupportsIndex, preload_N: SupportsFloat | SupportsIndex, input_angle_rad: SupportsFloat | SupportsIndex, numbers: SupportsGetItem[int, str], values: NDArray[float64], pressures: bool, threshold: str | None = None, coefficient: SupportsFloat | SupportsIndex | None = None) -> tuple[NDArray[uint8], list[str], NDArray[float64], list[str]]:
    """
    Judges many designs under one load on all cores. Ctrl-C stops it.

    Parameters
    ----------
    drive : Drive
        The drive whose numbers are replaced.
    torque_Nm, preload_N, input_angle_rad : float
        The load: N m, N and rad.
    numbers : list of str
        Names, in SI, of the numbers that are replaced.
    values : array
        The values of ``numbers``, row after row.
    pressures : bool
        Whether to compute the peak pressures, and what comes with them: static safety and torsional stiffness.
    threshold : str, optional
        The preload to compute: ``hold``, ``continuous`` or ``zero_backlash``; none for any other word.
    coefficient : float, optional
        Friction coefficient with which friction torque, efficiency and wear are computed, at the angle of the load.

    Returns
    -------
    tuple
        The status of each row as an index into the names that follow (``no_drive`` where the numbers make no drive), these
        names, a table with one row for each design, and the names of its columns. NaN where there is no solution or a column
        is not wanted.

    Raises
    ------
    InvalidInputError
        For an unknown name.
    """

def log_scale_prior(scales: NDArray[float64], stated_dof: SupportsFloat | SupportsIndex) -> NDArray[float64]:
    """
    Log prior of scales, 0 where one is 1, shape (n,).
    """

def noise_products(products: NoisePolynomials | Any, noise: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], shared: SupportsIndex) -> tuple[NDArray[float64], float]:
    """
    Products of columns through a noise of a scale, a correlation and offsets of runs, the last `shared` columns being a part of
    the noise, shape (m, m); and the log determinant of its covariance.

    Raises `numpy.linalg.LinAlgError` where that is no covariance.
    """

def own_effect_variables() -> list[tuple[str, str]]:
    """
    Variables that an own effect may depend on: name and meaning.
    """

def painted(text: str) -> str:
    """
    A text with the colours of the command line.
    """

def quadratic_step(curved: NDArray[float64], slope: NDArray[float64], bounds: tuple[NDArray[float64], NDArray[float64]], scale: NDArray[float64], radius: SupportsFloat | SupportsIndex) -> tuple[NDArray[float64], float]:
    """
    The step of the least ``z' curved z - 2 slope' z`` within bounds, shape (p,), and what it promises to gain.

    Parameters
    ----------
    curved : array, shape (p, p)
        Symmetric.
    slope : array, shape (p,)
        Half the slope of the gain where the step begins.
    bounds : tuple of array, shape (p,)
        Lower and upper ones of the step; 0 is between them.
    scale : array, shape (p,)
        By which the length of a step is measured, above 0.
    radius : float
        The longest step.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where the numbers are not finite.
    """

def run_command_line(arguments: SupportsGetItem[int, str]) -> int:
    """
    Runs the Rust verbs of the command line (program name first) and returns the exit code.
    """

def search_noise(products: NoisePolynomials | Any, columns: tuple[NDArray[float64], SupportsIndex], start: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], given: tuple[SupportsIndex, SupportsIndex, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], structures: bool) -> tuple[float, float, float, float]:
    """
    The noise that makes readings most likely, and its log likelihood with the prior of the scale, less its price.

    Parameters
    ----------
    products : NoisePolynomials or callable
        Of the readings, the columns of the unknowns, and those that are a part of the noise. A callable is given scale and
        correlation and returns products, products by run, and the log determinant of the covariance.
    columns : tuple
        Precision of the prior of each unknown, 0 where it is flat, shape (p,); how many columns are a part of the noise.
    start : tuple of float
        Scale, correlation and offset of runs to begin with.
    given : tuple
        Number of readings and of runs; typical uncertainty; repeats that what is stated is worth; the least scale; the largest
        correlation; what a correlation and offsets have to gain, each.
    structures : bool
        Whether correlation and offsets are sought, too.

    Returns
    -------
    tuple of float
        Scale, correlation, offset of runs, and the log likelihood.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where the covariance or the linear problem is not positive.
    """

def solve_angles(drive: Drive, torque_Nm: NDArray[float64], preload_N: NDArray[float64], input_angle_rad: NDArray[float64], shape: SupportsGetItem[int, SupportsIndex], progress: Any | None = None) -> tuple[NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[uint8], list[str]]:
    """
    Solves a drive for arrays of loads on all cores. Ctrl-C stops it.

    Parameters
    ----------
    drive : Drive
        A ball drive or a torsion spring.
    torque_Nm, preload_N, input_angle_rad : array, shape (n,)
        The loads: N m, N and rad. For a torsion spring, a preload of 0 means none.
    shape : list of int
        The shape of the n loads in C order, for messages.
    progress : callable, optional
        Called from time to time with the number of loads solved.

    Returns
    -------
    tuple
        Parts of the deceleration and of the equal-speed pair (rad; of a torsion spring, the first part is the whole angle),
        scaled residual, hold preload (N, NaN unless the status is ``beyond_hold``), the status as an index into the names
        that follow, each of shape (n,), and these names. NaN where there is no solution.

    Raises
    ------
    InvalidInputError
        For an invalid number; names its index.
    """

def sweep_findings() -> list[str]:
    """
    Reasons why the drive of a row cannot be built, by their codes; the first, empty, means that it can.
    """

def sweep_statuses() -> list[str]:
    """
    Names of the statuses of a row, by their codes.
    """

def take_out(gram: NDArray[float64], projection: NDArray[float64], square: SupportsFloat | SupportsIndex, precision: NDArray[float64]) -> tuple[NDArray[float64], NDArray[float64], float, float]:
    """
    Normal unknowns taken out of readings: the upper Cholesky factor of A = X'X + precisions, shape (p, p), the mode, shape
    (p,), misfit and priors there, and the log volume, half the log determinant of the precisions less half that of A.

    Parameters
    ----------
    gram : array, shape (p, p)
        X'X.
    projection : array, shape (p,)
        X'y.
    square : float
        y'y.
    precision : array, shape (p,)
        Of the prior of each unknown, 0 where it is flat.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where A is not positive.
    """

def terminal_colour(error: bool) -> bool:
    """
    Whether standard output, or standard error, shows colours: a terminal that can, and ``NO_COLOR`` is not set.
    """

def terminal_width() -> int:
    """
    Columns that text on standard output may take.
    """

def text_table(columns: SupportsGetItem[int, str], rows: SupportsGetItem[int, SupportsGetItem[int, bool | SupportsIndex | SupportsFloat | str | None]], width: SupportsIndex | None = None) -> str:
    """
    A text table as the command line draws it.

    ``columns`` are the column names; each row has a cell for each column. Numbers are shown to six significant digits;
    ``None`` and numbers that are not finite are shown as ``-``.
    The table is as wide as the terminal at most, 100 characters in a file; ``width`` says otherwise.
    """

def unit_size(text: str) -> float:
    """
    The SI value of one unit as people write it, for example ``arcsec/(N m)``. Raises ``ValueError`` where it is none.
    """

def units() -> list[Unit]:
    """
    Every unit that keys, columns and flags may carry, quantity by quantity, the SI unit of each first.
    """
