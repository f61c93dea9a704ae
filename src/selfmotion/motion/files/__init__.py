"""motion/files."""
