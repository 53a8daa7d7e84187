"""Find the gap between simulation and flight, name the effect, add it, show the gap shrink."""
