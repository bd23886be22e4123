"""Many runs of one scene: what to vary, running it on any number of workers, tables, and sensitivities."""
