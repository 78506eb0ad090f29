"""Landmarks: what a human teaches once, and a detector that finds it again in other light and season."""
