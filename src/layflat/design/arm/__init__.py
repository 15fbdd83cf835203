"""Arms from tasks: joints, links and masses that carry what an arm is asked to, as a description."""
