"""From measured maneuvers to derivatives with bounds: ML, least squares, subspace, FTR."""
