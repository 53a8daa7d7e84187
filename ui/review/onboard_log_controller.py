"""On-board logs in the window: asked for, fetched and aligned behind it, told in banners."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from ui.display_style import DisplayStyle
from ui.job_process.job_runner import JobRunner
from ui.review.job_queue import JobQueue
from ui.review.onboard_log_worker import OnboardLogJob, OnboardLogResult, create_log_job_runner
from ui.settings import SettingsStore
from ui.translation import tr
from ui.window_frame.banners import BannerStack
from ui.window_frame.job_banner import JobBanner

if TYPE_CHECKING:
    from gsapp.flight.flight import Flight
    from gsapp.flight.folder import FlightFolder
    from ui.review.onboard_log_dialog import FlightLogs


class OnboardLogController(QObject):
    """Takes logs into flights, one after the other; a fetch of an hour holds up nothing else."""

    log_applied = Signal(object)
    """The path of a flight whose samples are others now."""
    changed = Signal()

    def __init__(
        self,
        style: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        report_error: Callable[[BaseException], None],
        flights: Callable[[], Sequence[Flight]],
        others: Callable[[], Sequence[Path]],
        parent: QWidget,
        job_runner: JobRunner | None = None,
    ) -> None:
        super().__init__(parent)
        self._style = style
        self._store = store
        self._banners = banners
        self._flights = flights
        self._others = others
        self._parent = parent
        self.work = JobQueue(job_runner or create_log_job_runner(), report_error, self)
        self._banner = JobBanner(banners, self.work.cancel)
        self.work.began.connect(self._began)
        self.work.progressed.connect(self._show_progress)
        self.work.ended.connect(self._ended)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {"review_onboard": self.ask_for_log, "review_onboard_stop": self.work.cancel}

    @property
    def flight_folders(self) -> list[Path]:
        paths = [*(flight.path for flight in self._flights()), *self._others()]
        return [path for path in dict.fromkeys(one.resolve() for one in paths) if path.is_dir()]

    def ask_for_log(self) -> None:
        from gsapp.telemetry.log_download import parse_log_link
        from ui.dialogs.link_field import named_serial_ports
        from ui.review.onboard_log_dialog import OnboardLogDialog

        flights = self.candidate_flights()
        if not flights:
            return
        dialog = OnboardLogDialog(
            self._style, flights, self._store.current.links, parse_log_link, named_serial_ports,
            self._parent.window(),
        )  # fmt: skip
        if dialog.exec():
            self.submit(dialog.job)

    def submit(self, job: OnboardLogJob) -> None:
        """Begin a job, or let it wait."""
        if job.link:
            self._store.change(links=self._store.current.with_link(job.link).links)
        self.work.submit(job, self._done)

    def candidate_flights(self) -> tuple[FlightLogs, ...]:
        from gsapp.flight.folder import FlightFolder
        from gsapp.flight.onboard_log.log_storage import list_logs
        from gsapp.telemetry.recorder_control import find_recorder
        from ui.review.onboard_log_dialog import FlightLogs

        opened = {flight.path.resolve(): flight for flight in self._flights()}
        found = []
        for path in self.flight_folders:
            folder = FlightFolder(path=path)
            flight = opened.get(path)
            recorder = find_recorder(path)
            status = recorder.status() if recorder is not None else None
            found.append(
                FlightLogs(
                    path=path,
                    name=flight.name if flight is not None else path.name,
                    in_force=_applied_log_name(folder),
                    state=flight.onboard if flight is not None else None,
                    stored_logs=list_logs(folder),
                    link=status.link if status is not None else "",
                )
            )
        return tuple(found)

    def close(self) -> None:
        self.work.close()

    # Work

    def _began(self, title: str) -> None:
        self._banner.show(title)
        self.changed.emit()

    def _show_progress(self, share: float | None, text: str) -> None:
        self._banner.set_progress(share, text)

    def _ended(self, title: str, how: str) -> None:
        self._banner.remove()
        if how == "cancelled":
            self._banners.show_banner(
                "note",
                tr("{title}: stopped. The flight is unchanged; received data is kept.").format(
                    title=title
                ),
            )
        self.changed.emit()

    def _done(self, result: object) -> None:
        if not isinstance(result, OnboardLogResult):
            return
        back = OnboardLogJob(flight=result.flight, use=result.previous_log)
        self._banners.show_banner("note", result.text, (tr("Take back"), lambda: self.submit(back)))
        self.log_applied.emit(result.flight)


def _applied_log_name(folder: FlightFolder) -> str:
    info = folder.info()
    return info.onboard_log if info is not None else ""
