"""Reading flights and foreign logs."""
