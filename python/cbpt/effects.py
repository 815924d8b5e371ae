"""Effects of the user's own: an expression, or a function on whole arrays.

    >>> import cbpt
    >>> creep = cbpt.effects.expression(
    ...     "my_creep", "series", "a * torque_Nm * log(1 + run_time_s / tau)",
    ...     parameters={"a": {"unit": "rad/(N m)", "start": 1e-7, "min": 0.0, "max": 1e-5},
    ...                 "tau": {"unit": "s", "start": 20.0, "min": 1.0, "max": 1e4}})

- `expression`: what an `[[effect]]` with an expression in a case file is;
- `own_effect`: the same with a Python function;
- `VARIABLES`: what both may depend on, with what it is.

`compare`, `fit` and `diagnose` take them wherever they take ids of effects. Everything is in SI and
radians.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import OwnEffect, own_effect_variables
from cbpt.errors import InvalidInputError

__all__ = ["VARIABLES", "Columns", "OwnEffect", "expression", "own_effect"]

VARIABLES: dict[str, str] = dict(own_effect_variables())
"""Names of all variables, and what each is."""

Parameters = Mapping[str, float | Mapping[str, Any]]
"""By name: `start`, `unit`, `min`, `max`, of which only `start` is needed; or the start alone."""


class Columns(Mapping[str, NDArray[np.float64]]):
    """The columns that a function is given: arrays of shape (n,), not to be written to."""

    def __init__(self, columns: Mapping[str, NDArray[np.float64]], used: set[str]) -> None:
        self._columns = columns
        self._used = used

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        found = self._columns.get(name)
        if found is None:
            there = ", ".join(self._columns)
            raise InvalidInputError(
                f"no column {name!r} for an effect at this port; there are {there}"
            )
        self._used.add(name)
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)


class _Function:
    """A user's function as the core calls it."""

    def __init__(self, name: str, function: Callable[..., ArrayLike], names: tuple[str, ...]):
        self.name, self.function, self.names = name, function, names
        self.used: set[str] = set()

    def __call__(
        self, columns: Mapping[str, NDArray[np.float64]], values: list[float]
    ) -> NDArray[np.float64]:
        for column in columns.values():
            column.setflags(write=False)
        rows = len(columns["torque_Nm"])
        given = dict(zip(self.names, values, strict=True))
        found = np.asarray(self.function(Columns(columns, self.used), **given), dtype=np.float64)
        if found.shape not in ((), (rows,)):
            raise InvalidInputError(
                f"effect {self.name}: its function returned an array of shape {found.shape}, "
                f"expected one number for each of the {rows} rows it was given (a reversal of the "
                "torque between readings has rows of its own)"
            )
        return np.ascontiguousarray(np.broadcast_to(found, (rows,)))


def expression(
    id: str,
    port: str,
    expression: str,
    parameters: Parameters | None = None,
    *,
    adds_to: str | None = None,
) -> OwnEffect:
    """Make an own effect from a formula, as in a case file.

    Parameters
    ----------
    id : str
        Name of the effect.
    port : {"load", "series", "reading"}
        Where it acts. `series` and `reading` add an angle (rad), `load` adds to `adds_to` (N m, N).
    expression : str
        The formula in SI units and radians: numbers, parameters, `VARIABLES`, `pi`, `+ - * / ^` and
        functions. The page *Effects of your own* of the documentation lists them.
    parameters : mapping, optional
        By name: `start`, `unit`, `min` and `max`, of which only `start` is needed, or the start
        alone. `min` and `max` are the plausible range, which is the prior of a fit.
    adds_to : {"torque_Nm", "preload_N"}, optional
        What an effect at the port `load` adds to; needed there and nowhere else.

    Returns
    -------
    OwnEffect
        The effect; `compare`, `fit` and `diagnose` take it wherever they take ids.

    Raises
    ------
    CaseError
        The formula cannot be read. The message names the character and the nearest right name.

    Examples
    --------
    >>> import cbpt
    >>> shaft = cbpt.effects.expression("shaft", "series", "a * torque_Nm", {"a": 1e-6})
    >>> shaft.id
    'shaft'
    """
    entry: dict[str, Any] = {"id": id, "port": port, "expression": expression}
    if adds_to is not None:
        entry["adds_to"] = adds_to
    entry["parameters"] = {name: _filled(p) for name, p in (parameters or {}).items()}
    return OwnEffect.from_entry(entry)


def own_effect(
    id: str,
    port: str,
    function: Callable[..., ArrayLike],
    parameters: Parameters | None = None,
    *,
    adds_to: str | None = None,
) -> OwnEffect:
    """Make an own effect from a Python function of columns and parameters.

    A case file cannot hold such an effect.

    Parameters
    ----------
    id : str
        Name of the effect.
    port : {"load", "series", "reading"}
        Where it acts. `series` and `reading` add an angle (rad), `load` adds to `adds_to` (N m, N).
    function : callable
        Called as ``function(rows, a=..., ...)``. `rows` maps the names of `VARIABLES` to arrays of
        shape (n,), run by run in the order of time; `alpha_rad`, the elastic angle so far, is there
        at the port `reading` only. It returns n numbers, or one. Slopes are differences, so it is
        called a few times for each evaluation. What it raises reaches the caller.
    parameters : mapping, optional
        As in `expression`.
    adds_to : {"torque_Nm", "preload_N"}, optional
        What an effect at the port `load` adds to; needed there and nowhere else.

    Returns
    -------
    OwnEffect
        The effect; `compare`, `fit` and `diagnose` take it wherever they take ids.

    Raises
    ------
    CaseError
        A name, a port or a parameter is not possible.
    InvalidInputError
        The function returns an array of another shape.
    """
    parameters = parameters or {}
    filled = {name: _filled(p) for name, p in parameters.items()}
    fields = [(n, p["unit"], p["start"], p.get("min"), p.get("max")) for n, p in filled.items()]
    wrapped = _Function(id, function, tuple(parameters))
    return OwnEffect.from_function(id, port, adds_to, wrapped, fields)


def doubtful_names(effect: OwnEffect) -> list[str]:
    """A sentence for each parameter whose name is nearly that of a variable."""
    told = []
    for name, *_ in effect.parameters:
        if near := _variable_near(name):
            told.append(f"`{name}` is treated as a parameter; did you mean the variable `{near}`?")
    return told


def _variable_near(name: str) -> str | None:
    """The variable that a name may have meant: a slip in it, other capitals, or a word of it."""
    variables = {variable.lower(): variable for variable in VARIABLES}
    near = get_close_matches(name.lower(), variables, 1, 0.8)
    words = (v for v in variables if len(name) > 3 and name.lower() in v.split("_"))
    return variables[near[0]] if near else next((variables[v] for v in words), None)


def _filled(parameter: float | Mapping[str, Any]) -> dict[str, Any]:
    given = dict(parameter) if isinstance(parameter, Mapping) else {"start": float(parameter)}
    return {"unit": ""} | given
