"""The workbench: a project folder in the browser. Every action is a command line of `tribofmu`."""
