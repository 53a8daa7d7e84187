"""A banner that tells of a work while its own place is not on screen."""

from __future__ import annotations

from collections.abc import Callable

from ui.translation import tr
from ui.window_frame.banners import Banner, BannerStack


class JobBanner:
    """One banner, there or not."""

    def __init__(self, banners: BannerStack, stop: Callable[[], object]) -> None:
        self._banners = banners
        self._stop = stop
        self._banner: Banner | None = None
        self._end: Banner | None = None
        self._title = ""

    def show(self, title: str) -> None:
        """Tell of a work from now on."""
        self.remove()
        self._title = title
        self._banner = self._banners.show_banner("work", title, (tr("Stop"), self._stop))

    def set_progress(self, share: float | None, words: str) -> None:
        """Say how far it is, where the banner is there."""
        if self._banner is not None:
            self._banner.set_progress(share)
            self._banner.set_text(f"{self._title}: {words}")

    def remove(self) -> None:
        if self._banner is not None:
            self._banners.remove(self._banner)
            self._banner = None

    def show_result(self, words: str, offer: str, look: Callable[[], object]) -> None:
        """Tell what came of a work, and offer to look at it."""
        self.clear()
        self._end = self._banners.show_banner("note", words, (offer, look))

    def clear(self) -> None:
        """Tell nothing here of what the place itself shows now."""
        self.remove()
        if self._end is not None:
            self._banners.remove(self._end)
            self._end = None
