"""Long work beside the page: one piece at a time, with progress, to be cancelled.

Job         work on a thread of its own; what it does calls `step`, where a cancel takes hold
Cancelled   what `step` raises then
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from cbpt.errors import CbptError


class Cancelled(Exception):
    """The work is no longer wanted."""


class Job:
    """`work(step)` on a thread; `step(what, share)` tells where it is, or raises `Cancelled`."""

    def __init__(self, work: Callable[[Callable[[str, float], None]], object]) -> None:
        self.state, self.stage, self.share, self.error = "running", "", 0.0, ""
        self._work = work
        self._begun, self._ended = time.monotonic(), 0.0
        self._unwanted = threading.Event()
        self._thread = threading.Thread(target=self._run, name="cbpt-job", daemon=True)

    def start(self) -> Job:
        """Begin."""
        self._thread.start()
        return self

    def step(self, what: str, share: float) -> None:
        """Where the work is; raises `Cancelled` where it is no longer wanted."""
        if self._unwanted.is_set():
            raise Cancelled
        self.stage, self.share = what, share

    def _run(self) -> None:
        try:
            self._work(self.step)
            self.state, self.share = "done", 1.0
        except Cancelled:
            self.state = "cancelled"
        except CbptError as error:
            self.state, self.error = "failed", str(error)
        except Exception as error:  # told on the page; the server goes on
            self.state, self.error = "failed", f"{type(error).__name__}: {error}"
        self._ended = time.monotonic()

    @property
    def running(self) -> bool:
        """Whether it is still at work."""
        return self._thread.is_alive()

    @property
    def wanted(self) -> bool:
        """Whether it is at work and will tell what it finds."""
        return self.running and not self._unwanted.is_set()

    def cancel(self) -> None:
        """Not wanted any more; takes hold at the next step."""
        self._unwanted.set()

    def join(self, seconds: float) -> bool:
        """Wait for its end; False where it has not come."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def to_dict(self) -> dict[str, Any]:
        """As the page is told."""
        until = time.monotonic() if self.running else self._ended
        return {
            "state": self.state,
            "stage": self.stage,
            "share": self.share,
            "seconds": round(until - self._begun, 2),
            "error": self.error,
        }
