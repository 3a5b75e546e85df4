"""Commands that need ROS 2: a running node, the simulation, the smoke test."""
