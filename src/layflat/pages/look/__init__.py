"""Theme, charts, arm scene and refresh that all pages share."""
