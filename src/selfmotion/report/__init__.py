"""What results look like: `*_figures` draw, `*_page` say what they mean, `html` writes the file.

Nothing is analysed here, and apart from the viewer and the command line nothing else draws.
"""
