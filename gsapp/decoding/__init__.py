"""From frames to blocks: framing, messages, channel maps, vehicle time, calibration, air data."""
