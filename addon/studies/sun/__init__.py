"""The sun over a day: its moments and their pictures."""
