"""The closures against measurements: correlations of experiments (`correlations`), the program's beds (`beds`), the page
(`__main__`)."""
