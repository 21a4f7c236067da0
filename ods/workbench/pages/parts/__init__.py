"""What several menus show or do: rows of settings, the timeline, tables, files sent, links."""
