"""Numerics that every layer shares: how kernels are compiled, where roots lie."""
