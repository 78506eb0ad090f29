"""Landmarks: what a human teaches once beside an anchor, found again by itself, and where that says the robot is."""
