"""Failure causes for people and programs: sentences, objects for JSON, tables, a terminal."""
