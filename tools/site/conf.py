# SPDX-License-Identifier: Apache-2.0
"""Sphinx's settings for the manual. Sphinx and not MkDocs: its search reads its index as a script, so that it works in
pages that are opened from a disk, where browsers load no other files. No page asks for anything of the network."""
project = "panelcal"
extensions = ["myst_parser"]
# Anchors of headings, as GitHub makes them.
myst_heading_anchors = 4
html_theme = "sphinx_rtd_theme"
html_title = "panelcal"
html_copy_source = False
html_show_sourcelink = False
# Excerpts would be loaded from other pages, which a browser does not do from a disk.
html_show_search_summary = False
html_show_copyright = False
html_theme_options = {"navigation_depth": 2, "collapse_navigation": True}
# The text of docs is marked as program text without a language, and of the tutorials as what it is.
highlight_language = "none"
