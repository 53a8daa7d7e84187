"""Data compatibility, FTR, maximum likelihood, least squares, subspace, linear models."""
