"""Our solvers behind the interfaces of other projects."""
