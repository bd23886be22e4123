"""Reading tables, writing whole files, units. No physics."""
