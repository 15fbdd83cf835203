"""Is a rig what its description says? First without air, then with a little."""
