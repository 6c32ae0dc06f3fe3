"""What can be chosen: groups of settings, the options that reach them, their words, which of them apply together."""
