"""Models that the user is likely to ask for next, fitted while the server is idle.

    Turns    the order of work: requests first, preparation after them
    Ahead    the prepared models as JSON text, and the thread that prepares them

First come the sets of effects one switch away from the model shown: with one effect more, the
likeliest first, then with one less. When nothing else is to be done, the sets two switches away
follow, for a user who switches again before the first are ready. A prepared model equals the one
that would be fitted on request: the fit of a set does not depend on earlier fits (see `bench`).
"""

from __future__ import annotations

import sys
import threading
import time
import traceback
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from statistics import mean

from cbpt.errors import CbptError

Effects = tuple[str, ...]
"""Of a model, in the order in which they were asked for: its ladder has them so."""
Step = Callable[[], None]
"""Called between two pieces of work; what it raises ends the work."""

PAUSE_S = 0.5
"""After a request the browser draws, on the same cores."""
MOST = 256
MOST_BYTES = 64 << 20
MOST_FAR = 128
"""Sets two switches away, of which there are as many as candidates squared."""
MOST_FAR_S = 0.2
"""They are prepared where a model takes no longer on the average: minutes of work in the background
would slow down every switch that comes meanwhile, and a long table takes them."""


class Later(Exception):
    """Somebody waits for something else, or this is no longer wanted."""


class Turns:
    """Who goes first. Four ranks: what is asked for, what is prepared, the rest, and what may be
    asked for later (`spare`)."""

    def __init__(self) -> None:
        self._gate = threading.Condition()
        self._under_way: Counter[str] = Counter()
        self._last_s = -PAUSE_S
        self.ended = False

    @property
    def asked(self) -> bool:
        """Whether somebody waits now."""
        return self._under_way["asked"] > 0

    @contextmanager
    def first(self) -> Iterator[None]:
        """What is asked for in here goes before all else."""
        self._count("asked", 1)
        try:
            yield
        finally:
            self._last_s = time.monotonic()
            self._count("asked", -1)

    @property
    def resting(self) -> bool:
        """Whether something of the rest is under way."""
        return self._under_way["rest"] > 0

    @contextmanager
    def rest(self) -> Iterator[None]:
        """What is worked out in here, step by step (`last`), goes before what is spare."""
        self._count("rest", 1)
        try:
            yield
        finally:
            self._count("rest", -1)

    def prepare(self, more: int) -> None:
        """One more (1) or one less (-1) that prepares something."""
        self._count("prepared", more)

    def _count(self, rank: str, more: int) -> None:
        with self._gate:
            self._under_way[rank] += more
            self._gate.notify_all()

    def pause(self, pause_s: float, spare: Callable[[], bool] = lambda: False) -> bool:
        """Wait until there was no request for some time; False once the server ends.

        spare: whether the work to be done then is of the last rank.
        """
        with self._gate:
            while not self.ended:
                left = self._last_s + pause_s - time.monotonic()
                held = self.asked or (self.resting and spare())
                if not held and left <= 0:
                    return True
                self._gate.wait(None if held else left)
        return False

    def last(self) -> bool:
        """Wait until no request is served and nothing is prepared; False once the server ends."""
        with self._gate:
            self._gate.wait_for(
                lambda: self.ended or not (self.asked or self._under_way["prepared"])
            )
        return not self.ended

    def end(self) -> None:
        """End all waiting."""
        with self._gate:
            self.ended = True
            self._gate.notify_all()


class Ahead:
    """Prepared models of one diagnosis.

    made: a model as text. known: those that need not be prepared, whatever the order of effects.
    offered: the effects that there are switches for now, the likeliest first.
    """

    def __init__(
        self,
        turns: Turns,
        made: Callable[[Effects, Step], str],
        known: Collection[frozenset[str]],
        offered: Callable[[], Sequence[str]],
        most_effects: int,
        pause_s: float = PAUSE_S,
    ) -> None:
        self._turns, self._made, self._known = turns, made, known
        self._offered, self._most_effects, self._pause_s = offered, most_effects, pause_s
        self._lock = threading.RLock()
        self._texts: OrderedDict[Effects, str] = OrderedDict()
        self._about: frozenset[Effects] = frozenset()
        """All that the neighbourhood holds: what is prepared for it does not push it out."""
        self._near: frozenset[Effects] = frozenset()
        """What of it is one switch away; the rest is two."""
        self._wanted: list[Effects] = []
        self._preparing = False
        """Whether the first that is wanted is near, so that the rest waits for it."""
        self._cannot: set[Effects] = set()
        self._spent_s = deque([0.0], maxlen=64)
        """What the latest models took."""
        self._version = 0
        self._ended = False
        self._thread: threading.Thread | None = None

    def model(self, effects: Sequence[str]) -> str:
        """A model as text, prepared or made now. Raises what making it raises."""
        wanted = tuple(dict.fromkeys(effects))
        with self._lock:
            version = self._version
            if wanted in self._texts:
                self._texts.move_to_end(wanted)
                return self._texts[wanted]
        text = self._made(wanted, lambda: None)
        with self._lock:
            if version == self._version:
                self._keep(wanted, text, asked=True)
        return text

    def around(self, *models: Sequence[str]) -> None:
        """Prepare what is near these models, in place of what was wanted so far."""
        offered = self._offered()
        steps = [step for model in models for step in _one_switch(model, offered)]
        ranked = [
            (first + second, effects)
            for first, step in enumerate(steps)
            for second, effects in enumerate(_one_switch(step, offered))
        ]
        ranked.sort(key=lambda found: found[0])  # the likeliest by the places of both switches
        near = dict.fromkeys(filter(self._is_needed, steps))
        shown = {frozenset(model) for model in models}  # on and off again leads back
        far = dict.fromkeys(
            effects
            for _, effects in ranked
            if effects not in near and frozenset(effects) not in shown and self._is_needed(effects)
        )
        about = [*near, *list(far)[:MOST_FAR]]
        with self._lock:
            self._near, self._about = frozenset(near), frozenset(about)
            if self._ended or self._turns.ended:
                return self._want([])
            there = self._texts.keys() | self._cannot
            self._want([effects for effects in about if effects not in there])
            if self._wanted and self._thread is None:
                self._thread = threading.Thread(target=self._run, name="cbpt-ahead", daemon=True)
                self._thread.start()

    def _is_needed(self, effects: Effects) -> bool:
        return len(effects) <= self._most_effects and frozenset(effects) not in self._known

    def _want(self, wanted: list[Effects]) -> None:
        """Behind the lock."""
        self._wanted = wanted
        preparing = wanted[:1] != [] and wanted[0] in self._near
        if preparing != self._preparing:
            self._preparing = preparing
            self._turns.prepare(1 if preparing else -1)

    def forget(self) -> None:
        """Drop all prepared models and all that are wanted."""
        with self._lock:
            self._version += 1
            self._texts.clear()
            self._cannot.clear()
            self._want([])

    def end(self) -> None:
        """Stop preparing."""
        self._ended = True
        self.forget()

    @property
    def ready(self) -> list[Effects]:
        """What is prepared, the latest last."""
        with self._lock:
            return list(self._texts)

    def join(self, seconds: float) -> bool:
        """Wait until all that is wanted is prepared; False where it is not by then."""
        with self._lock:  # by then it has been started
            thread = self._thread
        if thread is not None:
            thread.join(seconds)
        return self._thread is None

    def _run(self) -> None:
        try:
            # What is wanted may change during the pause, and the lock is not for there.
            while self._turns.pause(self._pause_s, lambda: not self._preparing) and self._one():
                pass
        finally:
            with self._lock:
                if self._thread is threading.current_thread():
                    self._thread = None
                    self._want([])

    def _one(self) -> bool:
        """Prepare the next; False where there is none."""
        with self._lock:
            if not self._preparing and mean(self._spent_s) > MOST_FAR_S:
                self._want([])
            if not self._wanted:
                # Whoever wants more from now on begins a thread anew.
                self._thread = None
                return False
            effects, version, spare = self._wanted[0], self._version, not self._preparing

        def step() -> None:
            # Without the lock: the worst that can happen is one step too many.
            turns = self._turns
            waited_for = turns.asked or (spare and turns.resting)
            if waited_for or turns.ended or effects not in self._wanted[:1]:
                raise Later

        begun_s = time.monotonic()
        try:
            text = self._made(effects, step)
        except Later:
            return True
        except CbptError:
            text = None
        except Exception:
            # A mistake of ours: told once, where the server was started, and not made again.
            traceback.print_exc(file=sys.stderr)
            text = None
        self._spent_s.append(time.monotonic() - begun_s)
        with self._lock:
            if version == self._version:
                wanted = [w for w in self._wanted if w != effects]
                if text is None:
                    self._cannot.add(effects)
                elif not self._keep(effects, text, asked=False):
                    wanted = []
                self._want(wanted)
        return True

    def _keep(self, effects: Effects, text: str, asked: bool) -> bool:
        """Whether there is room for one more; the oldest goes first, for what is prepared only
        from farther away."""
        stays = frozenset() if asked else self._near if effects in self._near else self._about
        others = [e for e in self._texts if e != effects and e not in stays]
        kept = OrderedDict(self._texts)
        kept[effects] = text
        kept.move_to_end(effects)
        while len(kept) > MOST or sum(map(len, kept.values())) > MOST_BYTES:
            if not others:
                return False
            del kept[others.pop(0)]
        self._texts = kept
        return True


def _one_switch(effects: Sequence[str], offered: Sequence[str]) -> Iterator[Effects]:
    """As the page asks for them: the effects shown, sorted, and behind them the one switched on."""
    shown = tuple(sorted(effects))
    for more in offered:
        if more not in shown:
            yield (*shown, more)
    for less in shown:
        yield tuple(e for e in shown if e != less)
