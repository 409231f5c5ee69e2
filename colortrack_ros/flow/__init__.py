"""flow: messages in time, without ROS: order, backlog, pairing, pacing."""
