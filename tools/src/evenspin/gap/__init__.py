"""Why does the model not match: finds, names and adds the missing effect."""
