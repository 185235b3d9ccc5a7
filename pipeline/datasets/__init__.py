"""Collections of silhouettes: folders, MPEG-7, animals, the paper's collection, the embedded sample."""
