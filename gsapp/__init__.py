"""Ground station for flight-testing remotely piloted research aircraft."""
