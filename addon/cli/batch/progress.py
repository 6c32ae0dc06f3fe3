"""How far a batch is: a bar on a terminal, plain lines elsewhere. Everything goes to standard error."""

from __future__ import annotations

from contextlib import suppress
from typing import TextIO

from tqdm import tqdm

from ...scene.plain_text import shown_lines


class _Bar(tqdm):
    """Without tqdm's watching thread: none of ours outlives the command."""

    monitor_interval = 0


class Progress:
    """Lines of text, and below them on a terminal a bar for the inputs done. A single input gets no bar."""

    def __init__(self, total: int, stream: TextIO, is_quiet: bool = False) -> None:
        self._stream, self._is_quiet = stream, is_quiet
        has_bar = total > 1 and not is_quiet and stream.isatty()
        self._bar = _Bar(total=total, file=stream, unit="input", dynamic_ncols=True, leave=False) if has_bar else None

    def say(self, text: str) -> None:
        """A line that --quiet leaves out."""
        if not self._is_quiet:
            self.complain(text)

    def complain(self, text: str) -> None:
        """A line that is always shown, where there is somebody to see it; what is foreign in it is made plain."""
        with suppress(OSError):
            if self._bar is None:
                print(shown_lines(text), file=self._stream, flush=True)
            else:
                self._bar.write(shown_lines(text), file=self._stream)

    def advance(self) -> None:
        """One more input is done."""
        if self._bar is not None:
            self._bar.update()

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.close()
