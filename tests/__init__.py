"""Tests, which mirror `src/layflat`, and their helpers, which import as `tests.rig.devices`."""
