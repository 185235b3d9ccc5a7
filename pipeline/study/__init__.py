"""Studies of a finished run: what its tables say about the method, as a table, figures and a page of each."""
