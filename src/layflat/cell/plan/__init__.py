"""Planning of picks: choice of fruit and place, state machine of a pick, from descriptions and detections alone."""
