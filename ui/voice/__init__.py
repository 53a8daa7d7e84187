"""Spoken words and tones, for eyes that are on the aircraft.

`Voice` is what the window has one of. Which of two sentences is heard, and when, is decided by
`ui.voice.speech_queue` alone, which knows nothing of Qt.
"""
