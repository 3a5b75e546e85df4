"""What is commanded and why: the control logic, without ROS."""
