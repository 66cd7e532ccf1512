"""From exact tallies to estimates with their standard errors, kept in files."""
