"""Work of which only the latest request counts: a dragged hand asks faster than one answers."""

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Latest(Generic[T]):
    """A thread that does one piece of work after the other, and skips what has been overtaken.

    Attributes:
        done: how many pieces have been done.
    """

    def __init__(self, work: Callable[[T], None], failed: Callable[[Exception], None]) -> None:
        """Start the thread.

        Args:
            work: called in the thread with the latest request.
            failed: called in the thread with what `work` raised.
        """
        self.done = 0
        self._work, self._failed = work, failed
        self._request: list[T] = []
        self._ready = threading.Condition()
        self._busy = False
        self._stopped = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def ask(self, request: T) -> None:
        """Put a request in place of one that waits."""
        with self._ready:
            self._request = [request]
            self._ready.notify_all()

    def wait(self, timeout: float = 60.0) -> bool:
        """Wait until nothing waits and nothing is being done; tell whether that came (s)."""
        with self._ready:
            return self._ready.wait_for(lambda: not self._request and not self._busy, timeout)

    def stop(self) -> None:
        """End the thread after the piece it is at."""
        with self._ready:
            self._stopped = True
            self._ready.notify_all()
        self._thread.join(10.0)

    def _run(self) -> None:
        while True:
            with self._ready:
                self._busy = False
                self._ready.notify_all()
                self._ready.wait_for(lambda: self._request or self._stopped)
                if self._stopped:
                    return
                request = self._request.pop()
                self._busy = True
            try:
                self._work(request)
            except Exception as error:  # a studio goes on; what went wrong is shown
                self._failed(error)
            self.done += 1
