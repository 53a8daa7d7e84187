"""Python API: what the commands do, for notebooks and scripts; `gsapp` has its names."""
