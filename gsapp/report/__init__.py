"""Figures, HTML and PDF reports (matplotlib, Jinja2). No Qt."""
