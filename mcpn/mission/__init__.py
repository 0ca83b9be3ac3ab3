"""The mission language: model, reader and writer, validation, passes, flattening, static analysis."""
