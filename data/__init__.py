"""The paper's numbers and the assumptions; README.md beside this file gives their sources."""
