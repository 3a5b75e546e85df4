"""From radius and gravity to wraps and shapes, without ROS."""
