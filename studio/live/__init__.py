"""Sessions as long as the server runs: requests in, news out to every tab, work beside the event loop."""
