"""The wrap: a gripper as a rod that its actuator curls, and the pressure that wraps an object."""
