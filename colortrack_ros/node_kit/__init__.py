"""node_kit: what nodes are made of: parameters, start and end, topics and QoS, diagnostics."""
