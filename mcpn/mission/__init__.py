"""The mission language: model, reader and writer, validation, flattening."""
