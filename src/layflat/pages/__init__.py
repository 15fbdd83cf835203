"""Pages in the browser: the operator panel of a rig, the design studio, and how they are served."""
