"""Where a store's files are: in a folder, or on an object store. `base.Files` is the seam, `open_files` picks."""
