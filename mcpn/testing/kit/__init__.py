"""A kit that tests a set of templates: properties, missions to draw, and what to do with a failure."""
