"""Pages in the browser: operator panel of a rig, design studio, packing cell at work, and their server."""
