"""Results of a forming run: numbers, fields, files, pictures and pages."""
