"""What was learned so far, and what the next maneuver would bring, from information matrices."""
