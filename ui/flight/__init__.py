"""The Flight place: charts, controls below, panels beside."""
