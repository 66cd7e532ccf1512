"""Media: what lies inside a transparent body, or around it. One class a file."""
