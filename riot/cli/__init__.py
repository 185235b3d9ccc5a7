"""The commands of two files: make, show, trunks, print, slices."""
