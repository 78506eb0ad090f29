"""Andante maps a place from slow features and says where a robot is from one image."""
