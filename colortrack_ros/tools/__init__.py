"""tools: programs that people start by hand, such as demo, pick_color, evaluate and tune."""
