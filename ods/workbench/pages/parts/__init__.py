"""Parts of several menus: rows of settings, the timeline, tables, files sent, links."""
