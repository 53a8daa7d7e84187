"""Widgets that several pages use: buttons, tables, plots, forms and lists."""
