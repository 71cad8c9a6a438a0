"""Machinery without physics: errors, files, command conventions, processes, installation."""
