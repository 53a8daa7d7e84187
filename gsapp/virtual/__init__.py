"""Whole flights: a plan, a pilot who flies it by eye, and the record it leaves."""
