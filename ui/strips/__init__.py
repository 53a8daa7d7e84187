"""Strip charts."""
