"""Models that are likely to be asked for next, fitted while nobody asks for anything.

    Turns    what somebody waits for goes before what is worked out meanwhile
    Ahead    prepared models, as the text that is sent, and who prepares them

Prepared are the sets one switch away from the model shown: with one effect more, the likeliest
first, then with one less. A prepared model is the one that would be fitted when asked, since the
fit of a set does not depend on what was fitted before (see `bench`).
"""

from __future__ import annotations

import sys
import threading
import time
import traceback
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager

from cbpt.errors import CbptError

Effects = tuple[str, ...]
"""Of a model, in the order in which they were asked for: its ladder has them so."""
Step = Callable[[], None]
"""Called between two pieces of work; what it raises ends the work."""

PAUSE_S = 0.5
"""After a request the browser draws, on the same cores."""
MOST = 64
MOST_BYTES = 32 << 20


class Later(Exception):
    """Somebody waits for something else, or this is no longer wanted."""


class Turns:
    """Who goes first. Three ranks: what is asked for, what is prepared, and the rest."""

    def __init__(self) -> None:
        self._gate = threading.Condition()
        self._asked = self._preparing = 0
        self._last_s = -PAUSE_S
        self.ended = False

    @property
    def asked(self) -> bool:
        """Whether somebody waits now."""
        return self._asked > 0

    @contextmanager
    def first(self) -> Iterator[None]:
        """What is asked for in here goes before all else."""
        with self._gate:
            self._asked += 1
        try:
            yield
        finally:
            with self._gate:
                self._asked -= 1
                self._last_s = time.monotonic()
                self._gate.notify_all()

    def prepare(self, more: int) -> None:
        """One more (1) or one less (-1) that prepares something."""
        with self._gate:
            self._preparing += more
            self._gate.notify_all()

    def pause(self, pause_s: float) -> bool:
        """Wait until nobody has asked for some time; False at the end of all."""
        with self._gate:
            while not self.ended:
                left = self._last_s + pause_s - time.monotonic()
                if not self._asked and left <= 0:
                    return True
                self._gate.wait(None if self._asked else left)
        return False

    def last(self) -> bool:
        """Wait until nothing is asked for and nothing prepared; False at the end of all."""
        with self._gate:
            self._gate.wait_for(lambda: self.ended or not (self._asked or self._preparing))
        return not self.ended

    def end(self) -> None:
        """Nobody waits any more."""
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
        self._wanted: list[Effects] = []
        self._cannot: set[Effects] = set()
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
        """Prepare what is one switch away from these models, in place of what was wanted so far."""
        offered = self._offered()
        near = [step for model in models for step in _one_switch(tuple(sorted(model)), offered)]
        with self._lock:
            self._about = frozenset(near)
            self._wanted = [
                effects
                for effects in dict.fromkeys(near)
                if len(effects) <= self._most_effects
                and frozenset(effects) not in self._known
                and effects not in self._texts
                and effects not in self._cannot
            ]
            if self._ended or self._turns.ended:
                self._wanted = []
            elif self._wanted and self._thread is None:
                self._turns.prepare(1)
                self._thread = threading.Thread(target=self._run, name="cbpt-ahead", daemon=True)
                self._thread.start()

    def forget(self) -> None:
        """What was prepared holds no longer, and nothing is wanted."""
        with self._lock:
            self._version += 1
            self._texts.clear()
            self._cannot.clear()
            self._wanted = []

    def end(self) -> None:
        """Nothing is prepared any more."""
        self._ended = True
        self.forget()

    @property
    def ready(self) -> list[Effects]:
        """What is prepared, the latest last."""
        with self._lock:
            return list(self._texts)

    def join(self, seconds: float) -> bool:
        """Wait until all that is wanted is prepared; False where it is not by then."""
        thread = self._thread
        if thread is not None:
            thread.join(seconds)
        return self._thread is None

    def _run(self) -> None:
        try:
            while self._turns.pause(self._pause_s) and self._one():
                pass
        finally:
            with self._lock:
                if self._thread is threading.current_thread():
                    self._thread = None
            self._turns.prepare(-1)

    def _one(self) -> bool:
        """Prepare the next; False where there is none."""
        with self._lock:
            if not self._wanted:
                # Whoever wants more from now on begins a thread anew.
                self._thread = None
                return False
            effects, version = self._wanted[0], self._version

        def step() -> None:
            # Without the lock: the worst that can happen is one step too many.
            if self._turns.asked or self._turns.ended or effects not in self._wanted[:1]:
                raise Later

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
        with self._lock:
            if version == self._version:
                self._wanted = [w for w in self._wanted if w != effects]
                if text is None:
                    self._cannot.add(effects)
                elif not self._keep(effects, text, asked=False):
                    self._wanted = []
        return True

    def _keep(self, effects: Effects, text: str, asked: bool) -> bool:
        """Whether there is room for one more; the oldest goes first, for what is prepared only
        from outside the neighbourhood."""
        others = [e for e in self._texts if e != effects and (asked or e not in self._about)]
        kept = OrderedDict(self._texts)
        kept[effects] = text
        kept.move_to_end(effects)
        while len(kept) > MOST or sum(map(len, kept.values())) > MOST_BYTES:
            if not others:
                return False
            del kept[others.pop(0)]
        self._texts = kept
        return True


def _one_switch(effects: Effects, offered: Sequence[str]) -> Iterator[Effects]:
    """As the page asks for them: the effects shown, sorted, and behind them the one switched on."""
    for more in offered:
        if more not in effects:
            yield (*effects, more)
    for less in effects:
        yield tuple(e for e in effects if e != less)
