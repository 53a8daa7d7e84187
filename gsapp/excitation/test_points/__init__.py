"""Test points and the inputs wanted at them: from the card, the model, then from the flight."""
