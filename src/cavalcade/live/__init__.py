"""What runs in the world's own time: teams on robots, and simulations that others talk to."""
