"""The studio: a page in the browser in which teams are built, driven and studied."""
