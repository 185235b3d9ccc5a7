"""Files of a puzzle: solids to print, sheets to cut, pages to read."""
