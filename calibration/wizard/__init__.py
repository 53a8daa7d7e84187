"""The calibration wizard as a state machine: no window, no clock of its own.

`Wizard.feed` takes samples, `Wizard.act` what the crew does, `Wizard.view` is what to show.
"""

from calibration.wizard.ledger import unfinished
from calibration.wizard.schedule import Slot
from calibration.wizard.view import Action, WizardView
from calibration.wizard.wizard import Wizard

__all__ = ["Action", "Slot", "Wizard", "WizardView", "unfinished"]
