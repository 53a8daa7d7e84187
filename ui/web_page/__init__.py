"""A page for phones and tablets: the pilot's page and strip charts in any browser, read only."""
