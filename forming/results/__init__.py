"""What a forming run leaves behind: history, fields, files, pictures, pages."""
