"""What the controller does every 5 ms."""
