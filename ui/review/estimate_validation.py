"""What runs are made with, loaded in a thread; and what the form cannot ask for."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from gsapp.foundation import GroundStationError
from gsapp.foundation.settings import SettingError
from ui.background_job import BackgroundJob, JobProgress
from ui.estimate_form import EstimateForm
from ui.review.estimate_request import find_form_error, load_effect_parameters
from ui.translation import tr

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft


class EstimateValidator(QObject):
    """Validates forms once it has loaded what that takes."""

    loaded = Signal(object, object)
    """Names of the models and of the weights that come with the program."""

    def __init__(
        self, report_error: Callable[[BaseException], None], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.ready = False
        self.problem: SettingError | None = None
        """What could not be asked for when it was judged last."""
        self._validated: EstimateForm | None = None
        self._model = ""
        self.effects: Mapping[str, float] = {}
        work = BackgroundJob(tr("Loading the settings"), _load, self)
        work.done.connect(self._loaded)
        work.failed.connect(report_error)
        work.start()

    def _loaded(self, names: tuple[tuple[str, ...], tuple[str, ...]]) -> None:
        self.ready = True
        self.loaded.emit(*names)

    def invalidate(self) -> None:
        """Judge anew: files may be others now."""
        self._validated = None

    def validate(self, form: EstimateForm) -> SettingError | None:
        """Return what cannot be asked for; None if all is well, or nothing is loaded yet."""
        if self.ready and self._validated != form:
            self.problem = find_form_error(form)
            self._validated = form
        return self.problem

    def load_model_effects(self, model: str, aircraft: Aircraft) -> bool:
        """Find the parameters of the effects of a model; return whether it is another one."""
        if not self.ready or model == self._model:
            return False
        self._model, self.effects = model, {}
        if model:
            # A model that cannot be read is said beside its field.
            with contextlib.suppress(GroundStationError, OSError):
                self.effects = load_effect_parameters(model, aircraft)
        return True


def _load(_progress: JobProgress) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Import what takes a second; return the names of models and weights."""
    import gsapp.identification.runs.run_execution  # noqa: F401
    from gsapp.dynamics.model import shipped_models
    from gsapp.identification.weights import shipped_weights

    return shipped_models(), shipped_weights()
