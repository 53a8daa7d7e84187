"""What must be said before everything else: instruments that lie, limits that come near."""
