"""The core mission as sections: its objectives graph, where they lead, and what names of copies mean."""
