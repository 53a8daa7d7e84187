"""What surrounds every place: rail, bar, banners."""
