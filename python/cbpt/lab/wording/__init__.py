"""Names, numbers and units as text.

versions   what an answer was made with
"""
