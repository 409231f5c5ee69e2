"""tools: what people start by hand: demo, pick_color."""
