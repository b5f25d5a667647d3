"""What two checkouts leave of the same commands, compared byte for byte."""
