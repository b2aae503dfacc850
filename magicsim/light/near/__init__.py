"""Light that passes the contact face either way, compressed: pictures of what is near, for the fast tier."""
