"""The place Preflight: card, calibration, instruments, checklist, test cards."""
