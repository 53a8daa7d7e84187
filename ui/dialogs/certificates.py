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
from ui.translation import tr


class CertificatesDialog(FormDialog):
    """Asks for a set of certificates, and says what it would change."""

    def __init__(
        self,
        look: DisplayStyle,
        used: AppliedCertificates,
        shipped: Sequence[str],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("Other certificates"),
            tr(
                "Converts the recorded volts again. The certificates in the flight folder do not "
                "change."
            ),
            tr("Apply"),
            look,
            parent,
        )
        self._own = used.recorded
        self.certificates = ShippedFileField(
            tr("Certificates"),
            shipped,
            used.override_source,
            none=tr("Certificates of the flight"),
            folder=True,
        )
        self.message = FieldMessage()
        self.add_row(tr("Certificates"), self.certificates, self.message)
        self.certificates.currentIndexChanged.connect(self._validate)
        self._validate()
        self.fit_to_content(560)

    def _validate(self) -> None:
        given = self.certificates.value
        usable = True
        if not given:
            kept = len(self._own or {})
            words = tr("{certificates} in the flight folder.").format(
                certificates=count_text(kept, "certificate")
            )
            self.message.set_message(
                words if kept else tr("Certificates named by the channel map."), "good"
            )
        elif may_block(given):
            usable = False
            self.message.set_message(tr("{given} does not respond.").format(given=given), "warning")
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
