"""Linear models: from derivatives, by least squares, by subspace and prediction error."""
