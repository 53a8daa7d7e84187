"""Asks which certificates an old flight is to be read with."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtWidgets import QWidget

from calibration import load_certificates
from gsapp.flight.certificates import AppliedCertificates
from gsapp.foundation import GroundStationError
from ui.dialogs.file_fields import ShippedFileField
from ui.dialogs.form_dialog import FieldMessage, FormDialog
from ui.disk_checks import may_block
from ui.display_style import DisplayStyle
from ui.number_format import count_text


class CertificatesDialog(FormDialog):
    """Asks for a set of certificates, and says what it would change.

    Parameters
    ----------
    display_style : DisplayStyle
        Sizes.
    used : AppliedCertificates
        What the flight is read with now.
    shipped : sequence of str
        Sets that come with the program.
    """

    def __init__(
        self,
        look: DisplayStyle,
        used: AppliedCertificates,
        shipped: Sequence[str],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            "Other certificates",
            "Converts the recorded volts again. The certificates in the flight folder do not "
            "change.",
            "Apply",
            look,
            parent,
        )
        self._own = used.recorded
        self.certificates = ShippedFileField(
            "Certificates",
            shipped,
            used.override_source,
            none="Certificates of the flight",
            folder=True,
        )
        self.message = FieldMessage()
        self.add_row("Certificates", self.certificates, self.message)
        self.certificates.currentIndexChanged.connect(self._validate)
        self._validate()
        self.fit_to_content(560)

    def _validate(self) -> None:
        given = self.certificates.value
        usable = True
        if not given:
            kept = len(self._own or {})
            words = f"{count_text(kept, 'certificate')} in the flight folder."
            self.message.set_message(
                words if kept else "Certificates named by the channel map.", "good"
            )
        elif may_block(given):
            usable = False
            self.message.set_message(f"{given} does not respond.", "warning")
        else:
            try:
                chosen = load_certificates(given)
            except GroundStationError as error:
                usable = False
                self.message.set_message(str(error), "warning")
            else:
                said = AppliedCertificates(
                    applied=chosen, override_source=given, recorded=self._own
                ).override_text
                self.message.set_message(f"{said[:1].upper()}{said[1:]}.", "caution")
        self.button.setEnabled(usable)
