"""What each kind of bench makes of a log: a model that can be fitted."""
