"""The calibration wizard as a state machine: no window, no clock of its own.

`CalibrationWizard.feed` takes samples, `CalibrationWizard.act` what the crew does,
`CalibrationWizard.view` is what to show.
"""

from calibration.wizard.procedure import WizardAction, WizardView
from calibration.wizard.state import ScheduledSetting
from calibration.wizard.step_executor import has_unfinished_calibration
from calibration.wizard.wizard import CalibrationWizard

__all__ = [
    "CalibrationWizard",
    "ScheduledSetting",
    "WizardAction",
    "WizardView",
    "has_unfinished_calibration",
]
