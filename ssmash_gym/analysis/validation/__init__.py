"""The validation manoeuvres of section 3.2: its figures, and what it states against what comes out."""
