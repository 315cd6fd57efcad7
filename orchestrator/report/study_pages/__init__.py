"""Pages of the studies, and `saved_study`, which makes one again from its folder. They see the parts, charts and studies, no page outside."""
