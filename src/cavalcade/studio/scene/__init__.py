"""What is seen of ground, robots and plans, besides the panels."""
