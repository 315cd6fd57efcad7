"""Pages, one a file: models, effects, runs, tests, the demo, the story of a project. They see the parts, charts and sections, not each other."""
