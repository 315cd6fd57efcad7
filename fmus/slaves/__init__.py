"""Python behind FMUs: slaves of FMI (`*_slave`), solvers that know no FMI (`*_solver`, `core`), the process that serves the C front (`server`)."""
