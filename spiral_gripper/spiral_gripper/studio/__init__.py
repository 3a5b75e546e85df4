"""The studio: a gripper in three dimensions, in the browser."""
