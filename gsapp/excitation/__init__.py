"""Trim cues, verdicts on doublets, test points, advice, predicted bounds."""
