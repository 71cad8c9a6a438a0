"""Machinery without physics: errors, atomic files, command-line conventions, caches."""
