"""Results for people and programs: tables, plots, documents."""
