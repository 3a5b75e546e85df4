"""The command line ``spiral-gripper``."""
