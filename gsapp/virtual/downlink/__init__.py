"""The aircraft's box: volts and messages as sent, over any link."""
