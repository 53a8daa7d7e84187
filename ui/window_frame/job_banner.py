"""A banner that tells of a work while its own place is not on screen."""

from __future__ import annotations

from collections.abc import Callable

from ui.window_frame.banners import Banner, BannerStack


class JobBanner:
    """One banner, there or not.

    Parameters
    ----------
    banners : BannerStack
        Where it stands.
    stop : callable
        What its button does.
    """

    def __init__(self, banners: BannerStack, stop: Callable[[], object]) -> None:
        self._banners = banners
        self._stop = stop
        self._banner: Banner | None = None
        self._end: Banner | None = None
        self._title = ""

    def show(self, title: str) -> None:
        """Tell of a work from now on."""
        self.drop()
        self._title = title
        self._banner = self._banners.show_banner("work", title, ("Stop", self._stop))

    def tell(self, share: float | None, words: str) -> None:
        """Say how far it is, where the banner is there."""
        if self._banner is not None:
            self._banner.show_share(share)
            self._banner.say(f"{self._title}: {words}")

    def drop(self) -> None:
        """Take the banner away."""
        if self._banner is not None:
            self._banners.remove(self._banner)
            self._banner = None

    def show_end(self, words: str, offer: str, look: Callable[[], object]) -> None:
        """Tell what came of a work, and offer to look at it."""
        self.seen()
        self._end = self._banners.show_banner("note", words, (offer, look))

    def seen(self) -> None:
        """Tell nothing here of what the place itself shows now."""
        self.drop()
        if self._end is not None:
            self._banners.remove(self._end)
            self._end = None
