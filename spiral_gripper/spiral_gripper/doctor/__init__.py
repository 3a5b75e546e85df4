"""The doctor: is everything there, and does it fit together?"""
