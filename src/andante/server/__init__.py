"""The local page on which a person teaches landmarks: an adapter without algorithms."""
