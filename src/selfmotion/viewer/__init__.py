"""The studio in the browser: what is drawn (`scene`, `bones`, `playback`) and what answers."""
