"""Links, recorder, replay, and the virtual aircraft's box."""
