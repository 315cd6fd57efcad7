"""How well missing effects are found, on campaigns made by code that the diagnosis has never seen."""
