"""Feedback for the crew in flight: trimmed or not, was the input good, what to fly next. No Qt.

Throughout, unless a docstring says otherwise: values are SI and radians, times are flight time in
s; `rate` is that of the rows and their grid, Hz; `dt` lies between two ticks; `speed` is true
airspeed; `system`, ``US`` or ``SI``, is that of the units of the words.
"""
