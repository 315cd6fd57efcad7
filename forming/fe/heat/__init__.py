"""Heat: properties over temperature, conduction, temperature fields of the tools."""
