"""From an arm, or from recordings, to a model, what it lacks, and a report: step by step, so that
it can be paused, stopped and taken up again after whatever ended it."""
