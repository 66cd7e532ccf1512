"""What people look at: numbers as text, figures, drawings, reports."""
