"""What watches a rig from outside its controller: faults, what finds them, and what is then done."""
