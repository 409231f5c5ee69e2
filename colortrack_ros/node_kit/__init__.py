"""node_kit: what nodes share: parameters, startup and shutdown, topics and QoS, diagnostics."""
