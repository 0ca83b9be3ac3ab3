"""The language of mission files, as the model declares it: datatypes, forms of classes, the schema."""
