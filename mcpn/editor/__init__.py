"""Missions in an editor: a server of the Language Server Protocol for files of missions.

A file on its way is often no XML at all. Problems are those that the reader of missions finds
(:mod:`mcpn.mission.xml`), of the texts as they are typed; names, completion and places in a text are found by
a scan that goes on behind what is broken (:mod:`mcpn.editor.scan`).
"""
