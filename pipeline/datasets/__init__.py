"""Collections of silhouettes: folders, MPEG-7, animals, the paper's collection, and the embedded sample.

A collection is listed here (names, classes, digests) without reading a silhouette; reading one is `reading.open_item`.
Names, order and classes must depend on nothing but the files' names and bytes, and each rejected file must be listed
with a reason. tests/unit/test_datasets.py and tests/integration/test_fetch.py prove it.
"""
