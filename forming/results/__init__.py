"""Results of a forming run: numbers, fields, files; `pictures` draws them."""
