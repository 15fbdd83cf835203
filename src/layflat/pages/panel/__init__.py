"""The operator panel: a page on which a person runs a rig."""
