"""A mission among the actions and topics of ROS 2."""
