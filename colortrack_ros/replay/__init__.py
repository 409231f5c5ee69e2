"""replay: runs the chain of the nodes over a recording."""
